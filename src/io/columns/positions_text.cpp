// Positions on the Earth: fixes of a receiver and reference trajectories, also as RTKLIB writes
// them.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include <wayfare/core/gaussian.hpp>
#include <wayfare/core/geodesy.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/io/nav_text.hpp>

#include "io/columns/column_rows.hpp"
#include "io/columns/receiver_fixes.hpp"

namespace wayfare::io {
namespace {

// Headings of RTKLIB's solutions and the corresponding column names.
constexpr std::pair<std::string_view, std::string_view> kNames[] = {
    {"latitude(deg)", "lat_deg"}, {"longitude(deg)", "lon_deg"},
    {"height(m)", "h_m"},         {"Q", "q"},
    {"sdn(m)", "sn_m"},           {"sde(m)", "se_m"},
    {"sdu(m)", "sd_m"},           {"sdne(m)", "sne_m"},
    {"sdeu(m)", "seu_m"},         {"sdun(m)", "sun_m"},
    {"vn(m/s)", "vn_mps"},        {"ve(m/s)", "ve_mps"},
    {"vu(m/s)", "vu_mps"},        {"sdvn", "svn_mps"},
    {"sdve", "sve_mps"},          {"sdvu", "svd_mps"},
    {"roll(deg)", "roll_deg"},    {"pitch(deg)", "pitch_deg"},
    {"yaw(deg)", "yaw_deg"},      {"x-ecef(m)", "ecef_x_m"},
    {"y-ecef(m)", "ecef_y_m"},    {"z-ecef(m)", "ecef_z_m"},
    {"sdx(m)", "ecef_sx_m"},      {"sdy(m)", "ecef_sy_m"},
    {"sdz(m)", "ecef_sz_m"},      {"sdxy(m)", "ecef_sxy_m"},
    {"sdyz(m)", "ecef_syz_m"},    {"sdzx(m)", "ecef_szx_m"},
    {"vx(m/s)", "ecef_vx_mps"},   {"vy(m/s)", "ecef_vy_mps"},
    {"vz(m/s)", "ecef_vz_mps"}};

std::string our_name(std::string_view heading) {
  for (const auto& [theirs, ours] : kNames)
    if (theirs == heading) return std::string(ours);
  return "-";
}

/// The columns of an RTKLIB solution (.pos), geodetic in decimal degrees or Earth-fixed, by its '%'
/// heading; nullopt where it is none.
std::optional<ColumnFormat> rtklib_columns(std::string_view all, const ColumnFormat& format) {
  if (format.named()) return std::nullopt;
  ColumnFormat found = format;
  text::Lines lines(all);
  bool utc = false;
  for (std::string_view line; lines.next(line);) {
    std::vector<std::string_view> fields;
    if (line.starts_with('%')) {
      split_fields(line.substr(1), fields);
      if (fields.size() < 4 || our_name(fields[1]) == "-") continue;
      if (fields[0] != "GPST" && fields[0] != "UTC") continue;
      utc = fields[0] == "UTC";
      found.columns.clear();
      for (std::size_t i = 1; i < fields.size(); ++i) found.columns.push_back(our_name(fields[i]));
      continue;
    }
    if (found.columns.empty()) return std::nullopt;
    // The heading has one word for date and time, or week and time of week.
    split_fields(line, fields);
    if (fields.empty()) continue;
    const bool date = fields[0].find('/') != std::string_view::npos;
    const std::array<const char*, 2> time =
        date ? (utc ? std::array{"utc_date", "utc_clock"} : std::array{"date", "clock"})
             : std::array{"week", "tow_s"};
    found.columns.insert(found.columns.begin(), time.begin(), time.end());
    return found;
  }
  return std::nullopt;
}

/// From radians and metres; returns an error message, or an empty string.
std::string to_geodetic(const Eigen::Vector3d& lat_lon_h, Geodetic& position) {
  if (!lat_lon_h.allFinite()) return "the position is not finite";
  if (!(std::abs(lat_lon_h[0]) <= 1.5707963267948968)) return "the latitude is beyond a pole";
  if (!(std::abs(lat_lon_h[1]) <= 6.283185307179587)) return "the longitude is beyond 360 degrees";
  position = {Angle::radians(lat_lon_h[0]), Angle::radians(lat_lon_h[1]), lat_lon_h[2]};
  return {};
}

void append_position(std::string& out, const Geodetic& p) {
  append_numbers(out, {p.latitude.degrees(), p.longitude.degrees(), p.height_m});
}

constexpr Quantity kFix[] = {{"lat", Dimension::angle},       {"lon", Dimension::angle},
                             {"h", Dimension::length},        {"sn", Dimension::length},
                             {"se", Dimension::length},       {"sd", Dimension::length},
                             {"sne", Dimension::length},      {"seu", Dimension::length},
                             {"sun", Dimension::length},      {"vn", Dimension::speed},
                             {"ve", Dimension::speed},        {"vd", Dimension::speed},
                             {"svn", Dimension::speed},       {"sve", Dimension::speed},
                             {"svd", Dimension::speed},       {"vu", Dimension::speed},
                             {"sh", Dimension::length},       {"sv_h", Dimension::length},
                             {"speed", Dimension::speed},     {"course", Dimension::angle},
                             {"sspeed", Dimension::speed},    {"q", Dimension::none},
                             {"ecef_x", Dimension::length},   {"ecef_y", Dimension::length},
                             {"ecef_z", Dimension::length},   {"ecef_sx", Dimension::length},
                             {"ecef_sy", Dimension::length},  {"ecef_sz", Dimension::length},
                             {"ecef_sxy", Dimension::length}, {"ecef_syz", Dimension::length},
                             {"ecef_szx", Dimension::length}, {"ecef_vx", Dimension::speed},
                             {"ecef_vy", Dimension::speed},   {"ecef_vz", Dimension::speed}};
constexpr std::size_t kFixX = 22;

/// Variances from standard deviations; nullopt where one, or its square, is not positive and
/// finite.
std::optional<Eigen::Matrix3d> variances(const Eigen::Vector3d& sigma) {
  const Eigen::Vector3d squares = sigma.cwiseAbs2();
  if (!(sigma.minCoeff() > 0.0 && squares.minCoeff() > 0.0) || !squares.allFinite())
    return std::nullopt;
  return squares.asDiagonal();
}

/// RTKLIB writes signed roots of the covariances of axes 0 and 1, 1 and 2, 2 and 0.
void add_covariances(const Eigen::Vector3d& roots, Eigen::Matrix3d& covariance) {
  if (!roots.allFinite()) return;
  const auto from_root = [](double root) { return std::copysign(root * root, root); };
  Eigen::Matrix3d full = covariance;
  full(0, 1) = full(1, 0) = from_root(roots[0]);
  full(1, 2) = full(2, 1) = from_root(roots[1]);
  full(0, 2) = full(2, 0) = from_root(roots[2]);
  if (is_positive_definite(full)) covariance = full;
}

/// From Earth-fixed metres; returns an error message, or an empty string.
std::string from_ecef(const Eigen::Vector3d& ecef_m, Geodetic& position) {
  if (!ecef_m.allFinite()) return "the position is not finite";
  constexpr double kNearest_m = 6.3e6;  // geodetic coordinates are of the Earth's surface
  if (!(ecef_m.norm() >= kNearest_m && ecef_m.norm() <= 1e9))
    return "the Earth-fixed position is not near the Earth's surface, or above it";
  position = geodetic_from_ecef(ecef_m);
  return {};
}

std::string take_ecef(std::span<const double> v, GnssFix& fix) {
  const std::span<const double> e = v.subspan(kFixX);
  if (std::string fault = from_ecef(triple(e, 0), fix.position); !fault.empty()) return fault;
  const Eigen::Matrix3d to_ned = rotation_ecef_ned(fix.position).transpose();
  if (triple(e, 9).allFinite()) {
    fix.velocity_ned_mps = to_ned * triple(e, 9);
    fix.velocity_covariance_ned = 0.09 * Eigen::Matrix3d::Identity();  // RTKLIB writes none
  }
  if (triple(e, 3).hasNaN()) return {};
  auto covariance = variances(triple(e, 3));
  if (!covariance) return "a standard deviation is not positive";
  add_covariances(triple(e, 6), *covariance);
  fix.position_covariance_ned_m2 = to_ned * *covariance * to_ned.transpose();
  return {};
}

std::string take_position(std::span<const double> v, GnssFix& fix) {
  if (std::string fault = to_geodetic(triple(v, 0), fix.position); !fault.empty()) return fault;
  Eigen::Vector3d sigma = triple(v, 3);
  if (std::isnan(sigma[0])) sigma = {v[16] / std::sqrt(2.0), v[16] / std::sqrt(2.0), v[17]};
  if (sigma.hasNaN()) return {};
  const auto covariance = variances(sigma);
  if (!covariance) return "a standard deviation is not positive";
  fix.position_covariance_ned_m2 = *covariance;
  // The third axis of the covariances is up.
  add_covariances(Eigen::Vector3d(v[6], -v[7], -v[8]), fix.position_covariance_ned_m2);
  return {};
}

std::string take_velocity(std::span<const double> v, GnssFix& fix) {
  Eigen::Vector3d velocity = triple(v, 9);
  if (std::isnan(velocity[2])) velocity[2] = -v[15];
  Eigen::Vector3d sigma = triple(v, 12);
  if (sigma.hasNaN()) sigma.setConstant(std::isnan(v[20]) ? 0.3 : v[20]);
  if (std::isnan(velocity[0]) && v[18] >= 0.0 && std::isfinite(v[19])) {
    velocity.head<2>() = v[18] * Eigen::Vector2d(std::cos(v[19]), std::sin(v[19]));
    velocity[2] = 0.0;
    sigma[2] = std::hypot(sigma[2], 0.05 * v[18]);  // a slope of three degrees
  }
  if (velocity.hasNaN()) return {};
  if (!velocity.allFinite()) return "the velocity is not finite";
  const auto covariance = variances(sigma);
  if (!covariance) return "a standard deviation of the velocity is not positive";
  fix.velocity_ned_mps = velocity;
  fix.velocity_covariance_ned = *covariance;
  return {};
}

}  // namespace

Result<FixFile> parse_fixes(std::string_view all, const std::string& source,
                            const ColumnFormat& format) {
  if (!format.named())
    if (auto foreign = parse_foreign_fixes(all, source)) return *std::move(foreign);
  const auto rows =
      ColumnRows::open(all, source, rtklib_columns(all, format).value_or(format), kFix);
  if (!rows) return rows.error();
  const bool ecef = rows->has(kFixX) && rows->has(kFixX + 1) && rows->has(kFixX + 2);
  if (auto known = rows->require(0, 3); !ecef && !known) return known.error();
  FixFile file;
  file.columns = rows->uses();
  const auto take = [&](const ColumnRow& row) -> std::string {
    GnssFix fix;
    fix.time = row.time;
    std::string fault = ecef ? take_ecef(row.numbers, fix) : take_position(row.numbers, fix);
    if (fault.empty() && !ecef) fault = take_velocity(row.numbers, fix);
    if (!fault.empty()) return fault;
    const double q = row.numbers[21];
    file.fixes.push_back(std::move(fix));
    file.qualities.push_back(q >= 0.0 && q < 100.0 ? static_cast<int>(q) : 0);
    return {};
  };
  if (rows->for_each(take, file.problems) == 0) return no_content("fix", source, file.problems);
  return file;
}

Result<FixFile> read_fixes(const std::string& path, const ColumnFormat& format) {
  return read_and_parse(path, {}, parse_fixes, format);
}

std::string format_fixes(std::span<const GnssFix> fixes) {
  std::string out =
      "t_s lat_deg lon_deg h_m sn_m se_m sd_m sne_m seu_m sun_m "
      "vn_mps ve_mps vd_mps svn_mps sve_mps svd_mps\n";
  const auto root = [](double covariance) {
    return std::copysign(std::sqrt(std::abs(covariance)), covariance);
  };
  for (const GnssFix& fix : fixes) {
    append_time(out, fix.time);
    append_position(out, fix.position);
    const Eigen::Matrix3d& p = fix.position_covariance_ned_m2;
    append_numbers(out, p.diagonal().cwiseSqrt().eval());
    append_numbers(out, std::array{root(p(0, 1)), root(-p(1, 2)), root(-p(0, 2))});
    const Eigen::Vector3d unknown =
        Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
    append_numbers(out, fix.velocity_ned_mps.value_or(unknown));
    append_numbers(out, fix.velocity_covariance_ned.diagonal().cwiseSqrt().eval());
    out += '\n';
  }
  return out;
}

namespace {

constexpr Quantity kNav[] = {
    {"lat", Dimension::angle},     {"lon", Dimension::angle},     {"h", Dimension::length},
    {"vn", Dimension::speed},      {"ve", Dimension::speed},      {"vd", Dimension::speed},
    {"roll", Dimension::angle},    {"pitch", Dimension::angle},   {"yaw", Dimension::angle},
    {"vu", Dimension::speed},      {"ecef_x", Dimension::length}, {"ecef_y", Dimension::length},
    {"ecef_z", Dimension::length}, {"ecef_vx", Dimension::speed}, {"ecef_vy", Dimension::speed},
    {"ecef_vz", Dimension::speed}};
constexpr std::size_t kNavX = 10;

NavFile as_nav(FixFile fixes) {
  NavFile file;
  file.problems = std::move(fixes.problems);
  file.has_velocity = std::all_of(fixes.fixes.begin(), fixes.fixes.end(),
                                  [](const GnssFix& f) { return f.velocity_ned_mps.has_value(); });
  for (const GnssFix& fix : fixes.fixes)
    file.trajectory.push_back(
        {fix.time, fix.position, fix.velocity_ned_mps.value_or(Eigen::Vector3d::Zero()), {}});
  return file;
}

}  // namespace

Result<NavFile> parse_nav(std::string_view all, const std::string& source,
                          const ColumnFormat& format) {
  if (!format.named()) {
    if (auto foreign = parse_foreign_fixes(all, source)) {
      if (!*foreign) return foreign->error();
      return as_nav(**std::move(foreign));
    }
  }
  const auto rows =
      ColumnRows::open(all, source, rtklib_columns(all, format).value_or(format), kNav);
  if (!rows) return rows.error();
  const auto has_all = [&rows](std::size_t i) {
    return rows->has(i) && rows->has(i + 1) && rows->has(i + 2);
  };
  const bool ecef = has_all(kNavX);
  if (auto known = rows->require(0, 3); !ecef && !known) return known.error();
  NavFile file;
  file.columns = rows->uses();
  file.has_velocity =
      ecef ? has_all(kNavX + 3) : rows->has(3) && rows->has(4) && (rows->has(5) || rows->has(9));
  file.has_attitude = rows->has(6) && rows->has(7) && rows->has(8);
  const auto take = [&](const ColumnRow& row) -> std::string {
    NavState state;
    state.time = row.time;
    const std::span<const double> v = row.numbers;
    const std::string fault = ecef ? from_ecef(triple(v, kNavX), state.position)
                                   : to_geodetic(triple(v, 0), state.position);
    if (!fault.empty()) return fault;
    if (file.has_velocity && ecef) {
      state.velocity_ned_mps = rotation_ecef_ned(state.position).transpose() * triple(v, kNavX + 3);
    } else if (file.has_velocity) {
      state.velocity_ned_mps = {v[3], v[4], rows->has(5) ? v[5] : -v[9]};
    }
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
