// Speeds of wheels.

#include <array>
#include <cmath>

#include <wayfare/io/nav_text.hpp>

#include "io/columns/column_rows.hpp"

namespace wayfare::io {
namespace {

constexpr Quantity kWheels[] = {{"speed", Dimension::speed}};

}  // namespace

Result<WheelsFile> parse_wheels(std::string_view all, const std::string& source,
                                const ColumnFormat& format) {
  const auto rows = ColumnRows::open(all, source, format, kWheels, 1);
  if (!rows) return rows.error();
  WheelsFile file;
  file.columns = rows->uses();
  const auto take = [&](const ColumnRow& row) -> std::string {
    if (!(std::abs(row.numbers[0]) < 1000.0)) return "the speed is not a number below 1000 m/s";
    file.readings.push_back({row.time, row.numbers[0]});
    return {};
  };
  if (rows->for_each(take, file.problems) == 0)
    return no_content("wheel speed", source, file.problems);
  return file;
}

Result<WheelsFile> read_wheels(const std::string& path, const ColumnFormat& format) {
  return read_and_parse(path, {}, parse_wheels, format);
}

std::string format_wheels(std::span<const WheelSpeed> readings) {
  std::string out = "t_s speed_mps\n";
  for (const WheelSpeed& reading : readings) {
    append_time(out, reading.time);
    append_numbers(out, std::array{reading.speed_mps});
    out += '\n';
  }
  return out;
}

}  // namespace wayfare::io
