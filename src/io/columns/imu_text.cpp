#include <array>
#include <cmath>

#include <wayfare/io/nav_text.hpp>

#include "io/columns/column_rows.hpp"

namespace wayfare::io {
namespace {

constexpr std::array kImu = {
    Quantity{"gx", Dimension::angular_rate}, Quantity{"gy", Dimension::angular_rate},
    Quantity{"gz", Dimension::angular_rate}, Quantity{"ax", Dimension::acceleration},
    Quantity{"ay", Dimension::acceleration}, Quantity{"az", Dimension::acceleration}};

constexpr std::array kClock = {Quantity{"device", Dimension::time}};

}  // namespace

Result<ImuFile> parse_imu(std::string_view all, const std::string& source,
                          const ColumnFormat& format) {
  const auto rows = ColumnRows::open(all, source, format, kImu);
  if (!rows) return rows.error();
  ImuFile file;
  file.has_gyro = rows->has(0) || rows->has(1) || rows->has(2);
  file.has_accelerometer = rows->has(3) || rows->has(4) || rows->has(5);
  const bool either = file.has_gyro || file.has_accelerometer;
  if (file.has_gyro || !either)
    if (auto present = rows->require(0, 3); !present) return present.error();
  if (file.has_accelerometer)
    if (auto present = rows->require(3, 6); !present) return present.error();
  const auto take = [&](const ColumnRow& row) -> std::string {
    ImuSample sample{row.time, triple(row.numbers, 0), triple(row.numbers, 3)};
    if (!file.has_gyro) sample.angular_rate_radps.setZero();
    if (!file.has_accelerometer) sample.specific_force_mps2.setZero();
    if (!sample.angular_rate_radps.allFinite() || !sample.specific_force_mps2.allFinite())
      return "a reading is not finite";
    file.samples.push_back(sample);
    file.ends.push_back({row.line, row.end_byte});
    return {};
  };
  if (rows->for_each(take, file.problems) == 0)
    return no_content("inertial sample", source, file.problems);
  return file;
}

Result<ImuFile> read_imu(const std::string& path, const ColumnFormat& format) {
  return read_and_parse(path, {}, parse_imu, format);
}

std::vector<ImuSample> merge_imu_parts(std::span<const ImuSample> gyro,
                                       std::span<const ImuSample> accelerometer, Duration max_gap) {
  std::vector<ImuSample> merged;
  std::size_t next = 0;
  for (const ImuSample& g : gyro) {
    while (next < accelerometer.size() && accelerometer[next].time < g.time) ++next;
    if (next == accelerometer.size()) break;
    const ImuSample& after = accelerometer[next];
    ImuSample sample = g;
    sample.specific_force_mps2 = after.specific_force_mps2;
    if (after.time != g.time) {
      if (next == 0) continue;
      const ImuSample& before = accelerometer[next - 1];
      if (after.time - before.time > max_gap) continue;
      const double fraction =
          to_seconds(g.time - before.time) / to_seconds(after.time - before.time);
      sample.specific_force_mps2 +=
          (fraction - 1.0) * (after.specific_force_mps2 - before.specific_force_mps2);
    }
    merged.push_back(sample);
  }
  return merged;
}

std::string format_imu(std::span<const ImuSample> samples) {
  std::string out = "t_s gx_radps gy_radps gz_radps ax_mps2 ay_mps2 az_mps2\n";
  out.reserve(samples.size() * 140);
  for (const ImuSample& sample : samples) {
    append_time(out, sample.time);
    append_numbers(out, sample.angular_rate_radps);
    append_numbers(out, sample.specific_force_mps2);
    out += '\n';
  }
  return out;
}

Result<ClockFile> parse_clock(std::string_view all, const std::string& source,
                              const ColumnFormat& format) {
  const auto rows = ColumnRows::open(all, source, format, kClock, 1);
  if (!rows) return rows.error();
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
