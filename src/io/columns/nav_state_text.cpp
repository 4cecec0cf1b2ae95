#include <array>
#include <cmath>

#include <wayfare/core/so3.hpp>
#include <wayfare/io/nav_text.hpp>

#include "io/columns/column_rows.hpp"
#include "io/columns/nav_columns.hpp"
#include "io/text/lines.hpp"

namespace wayfare::io {
namespace {

constexpr std::array kNav = {
    Quantity{"lat", Dimension::angle},  Quantity{"lon", Dimension::angle},
    Quantity{"h", Dimension::length},   Quantity{"vn", Dimension::speed},
    Quantity{"ve", Dimension::speed},   Quantity{"vd", Dimension::speed},
    Quantity{"roll", Dimension::angle}, Quantity{"pitch", Dimension::angle},
    Quantity{"yaw", Dimension::angle},  Quantity{"vu", Dimension::speed}};

}  // namespace

Result<NavFile> parse_nav(std::string_view all, const std::string& source,
                          const ColumnFormat& format) {
  const auto rows =
      ColumnRows::open(all, source, rtklib_columns(all, format).value_or(format), kNav);
  if (!rows) return rows.error();
  if (auto present = rows->require(0, 3); !present) return present.error();
  NavFile file;
  file.has_velocity = rows->has(3) && rows->has(4) && (rows->has(5) || rows->has(9));
  file.has_attitude = rows->has(6) && rows->has(7) && rows->has(8);
  const auto take = [&](const ColumnRow& row) -> std::string {
    NavState state;
    state.time = row.time;
    const std::span<const double> v = row.numbers;
    if (std::string fault = to_geodetic(triple(v, 0), state.position); !fault.empty()) return fault;
    if (file.has_velocity) state.velocity_ned_mps = {v[3], v[4], rows->has(5) ? v[5] : -v[9]};
    if (!state.velocity_ned_mps.allFinite()) return "the velocity is not finite";
    if (file.has_attitude) {
      if (!triple(v, 6).allFinite()) return "an angle is not finite";
      state.q_nb = rotation_from_roll_pitch_yaw(triple(v, 6));
    }
    file.trajectory.push_back(state);
    return {};
  };
  if (rows->for_each(take, file.problems) == 0)
    return no_content("position", source, file.problems);
  return file;
}

Result<NavFile> read_nav(const std::string& path, const ColumnFormat& format) {
  return read_and_parse(path, {}, parse_nav, format);
}

std::string format_nav(std::span<const NavState> trajectory) {
  std::string out = "t_s lat_deg lon_deg h_m vn_mps ve_mps vd_mps roll_deg pitch_deg yaw_deg\n";
  out.reserve(trajectory.size() * 180);
  for (const NavState& state : trajectory) {
    append_time(out, state.time);
    append_position(out, state.position);
    append_numbers(out, state.velocity_ned_mps);
    for (const double angle : roll_pitch_yaw_rad(state.q_nb))
      append_numbers(out, std::array{Angle::radians(angle).degrees()});
    out += '\n';
  }
  return out;
}

}  // namespace wayfare::io
