#include <array>
#include <cmath>

#include <wayfare/io/nav_text.hpp>

#include "io/columns/column_rows.hpp"
#include "io/text/lines.hpp"

namespace wayfare::io {
namespace {

constexpr std::array kClock = {Quantity{"device", Dimension::time}};

}  // namespace

Result<ClockFile> parse_clock(std::string_view all, const std::string& source,
                              const ColumnFormat& format) {
  const auto rows = ColumnRows::open(all, source, format, kClock);
  if (!rows) return rows.error();
  if (auto present = rows->require(0, 1); !present) return present.error();
  ClockFile file;
  const auto take = [&](const ColumnRow& row) -> std::string {
    if (std::isnan(row.numbers[0])) return "the device's time is missing";
    file.pairs.push_back({Time<DeviceClock>::from_seconds(row.numbers[0]), row.time});
    return {};
  };
  if (rows->for_each(take, file.problems) == 0)
    return no_content("pair of times", source, file.problems);
  return file;
}

Result<ClockFile> read_clock(const std::string& path, const ColumnFormat& format) {
  return read_and_parse(path, {}, parse_clock, format);
}

}  // namespace wayfare::io
