// Samples of an inertial unit, and what relates its clock to GPS time.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include <wayfare/core/detail/bytes.hpp>
#include <wayfare/io/nav_text.hpp>

#include "io/columns/column_rows.hpp"

namespace wayfare::io {
namespace {

constexpr Quantity kImu[] = {{"gx", Dimension::angular_rate}, {"gy", Dimension::angular_rate},
                             {"gz", Dimension::angular_rate}, {"ax", Dimension::acceleration},
                             {"ay", Dimension::acceleration}, {"az", Dimension::acceleration}};

constexpr Quantity kClock[] = {{"device", Dimension::time}};

constexpr std::size_t kHeader = 76;
constexpr std::size_t kRecord = 8;

}  // namespace

Result<ImuFile> parse_imu(std::string_view all, const std::string& source,
                          const ColumnFormat& format) {
  const auto rows = ColumnRows::open(all, source, format, kImu);
  if (!rows) return rows.error();
  ImuFile file;
  file.columns = rows->uses();
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
  file.columns = rows->uses();
  const auto take = [&](const ColumnRow& row) -> std::string {
    if (std::isnan(row.numbers[0])) return "the device's time is missing";
    if (std::abs(row.numbers[0]) > 1e-9 * static_cast<double>(kLargestStamp_ns))
      return "the device's time is too large";
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

Result<TimeTagFile> parse_time_tags(std::string_view bytes, const std::string& source) {
  if (!bytes.starts_with("TIMETAG RTKLIB") || bytes.size() < kHeader)
    return Error{ErrorCode::parse, "does not begin as RTKLIB's time tags do", source};
  const auto start_s = static_cast<std::int64_t>(decode::load_le<std::uint32_t>(bytes, 64));
  const auto fraction_s = decode::load_le<double>(bytes, 68);
  if (!(fraction_s >= 0.0 && fraction_s < 1.0))
    return Error{ErrorCode::parse, "the start is not a time", source, 0, 68};
  const LogTime start = LogTime::from_nanoseconds((start_s - kGpsEpochUnix_s) * 1'000'000'000) +
                        from_seconds(fraction_s);
  TimeTagFile file;
  for (std::size_t at = kHeader; at + kRecord <= bytes.size(); at += kRecord) {
    const auto tick_ms = decode::load_le<std::uint32_t>(bytes, at);
    const TimeTag tag{decode::load_le<std::uint32_t>(bytes, at + 4),
                      start + std::chrono::milliseconds(tick_ms)};
    if (!file.tags.empty() &&
        (tag.time < file.tags.back().time || tag.bytes < file.tags.back().bytes)) {
      file.problems.add(Error{ErrorCode::parse, "a time tag out of order", source, 0, at});
      continue;
    }
    file.tags.push_back(tag);
  }
  if (file.tags.empty()) return Error{ErrorCode::parse, "contains no time tag", source};
  return file;
}

Result<TimeTagFile> read_time_tags(const std::string& path) {
  return read_and_parse(path, {}, parse_time_tags);
}

Result<ClockFit<LogClock>> fit_time_tags(const ImuFile& file, const TimeTagFile& tags) {
  if (file.ends.size() != file.samples.size())
    return Error{ErrorCode::invalid,
                 "time tags need samples of a text file: these have no positions in bytes"};
  // With CR LF, the position of the last tag exceeds the file's size by one byte per line.
  std::uint64_t last_line = 0;
  if (!file.ends.empty()) last_line = file.ends.back().line;
  const std::uint64_t size = file.ends.empty() ? 0 : file.ends.back().byte;
  const bool carriage_returns =
      !tags.tags.empty() && tags.tags.back().bytes >= size + last_line - last_line / 10;
  std::vector<ClockPair<LogClock>> pairs;
  for (std::size_t i = 0; i < file.samples.size(); ++i) {
    const std::uint64_t end = file.ends[i].byte + (carriage_returns ? file.ends[i].line : 0);
    const auto tag =
        std::lower_bound(tags.tags.begin(), tags.tags.end(), end,
                         [](const TimeTag& t, std::uint64_t b) { return t.bytes < b; });
    if (tag == tags.tags.end()) break;
    pairs.push_back({file.samples[i].time, tag->time});
  }
  return fit_clock<LogClock>(pairs);
}

namespace {

constexpr std::string_view kTableMagic = "F32 ";
constexpr std::size_t kTableHeader = 16;

}  // namespace

Result<FloatTable> parse_float_table(std::string_view bytes, const std::string& source) {
  const auto error = [&](const char* message, std::size_t byte) {
    return Error{ErrorCode::parse, message, source, 0, byte};
  };
  if (bytes.substr(0, kTableMagic.size()) != kTableMagic)
    return error("does not begin with 'F32 '", 0);
  if (bytes.size() < kTableHeader) return error("ends within its header", bytes.size());
  const auto columns = decode::load_le<std::int32_t>(bytes, 4);
  const auto rows = decode::load_le<std::int64_t>(bytes, 8);
  if (columns < 1 || columns > 65536) return error("the number of columns is not in 1 to 65536", 4);
  if (rows < 0) return error("has a negative number of rows", 8);
  FloatTable table;
  table.columns = static_cast<std::size_t>(columns);
  const std::string_view body = bytes.substr(kTableHeader);
  const std::size_t available = body.size() / (sizeof(float) * table.columns);
  const auto wanted = static_cast<std::size_t>(rows);
  if (available > wanted ||
      (available == wanted && body.size() % (sizeof(float) * table.columns) != 0))
    return error("has bytes after its last row",
                 kTableHeader + wanted * table.columns * sizeof(float));
  if (available == 0) return error("contains no rows", kTableHeader);
  if (available < wanted) table.problems.add(error("ends before its last row", bytes.size()));
  table.values.resize(available * table.columns);
  for (std::size_t i = 0; i < table.values.size(); ++i)
    table.values[i] = decode::load_le<float>(body, i * sizeof(float));
  return table;
}

Result<FloatTable> read_float_table(const std::string& path, const ReadOptions& options) {
  return read_and_parse(path, options, parse_float_table);
}

std::string format_float_table(std::span<const float> values, std::size_t columns) {
  WAYFARE_EXPECTS(columns > 0 && values.size() % columns == 0, "the rows must be of equal length");
  std::string out(kTableMagic);
  const auto append = [&](auto value) {
    std::uint8_t raw[sizeof value];
    decode::store_le(value, raw);
    out.append(raw, raw + sizeof raw);
  };
  append(static_cast<std::int32_t>(columns));
  append(static_cast<std::int64_t>(values.size() / columns));
  for (const float value : values) append(value);
  return out;
}

namespace {

constexpr std::size_t kForce = 3, kField = 6, kAttitude = 9, kMoving = 13, kPressure = 14;
constexpr Quantity kMarg[] = {{"gx", Dimension::angular_rate},   {"gy", Dimension::angular_rate},
                              {"gz", Dimension::angular_rate},   {"ax", Dimension::acceleration},
                              {"ay", Dimension::acceleration},   {"az", Dimension::acceleration},
                              {"mx", Dimension::magnetic_field}, {"my", Dimension::magnetic_field},
                              {"mz", Dimension::magnetic_field}, {"qw", Dimension::none},
                              {"qx", Dimension::none},           {"qy", Dimension::none},
                              {"qz", Dimension::none},           {"moving", Dimension::none},
                              {"p", Dimension::pressure}};

MargReference reference_of(std::span<const double> v) {
  const Eigen::Quaterniond q(v[kAttitude], v[kAttitude + 1], v[kAttitude + 2], v[kAttitude + 3]);
  const bool known = std::abs(q.norm() - 1.0) < 0.01;
  return {known ? SO3d(q) : SO3d(), known};
}

Result<MargFile> parse_rows(std::string_view text, const std::string& source,
                            const ColumnFormat& format) {
  const auto rows = ColumnRows::open(text, source, format, kMarg, kField);
  if (!rows) return rows.error();
  MargFile file;
  file.has_magnetometer = rows->has(kField);
  if (file.has_magnetometer)
    if (auto present = rows->require(kField, kAttitude); !present) return present.error();
  const bool has_reference = rows->has(kAttitude);
  if (has_reference)
    if (auto present = rows->require(kAttitude, kMoving); !present) return present.error();
  const auto take = [&](const ColumnRow& row) -> std::string {
    const std::span<const double> v = row.numbers;
    if (std::any_of(v.begin(), v.end(), [](double x) { return std::isinf(x); }))
      return "a reading is infinite";
    file.samples.push_back({row.time, triple(v, 0), triple(v, kForce), triple(v, kField)});
    if (has_reference) file.reference.push_back(reference_of(v));
    if (rows->has(kPressure)) file.pressure_Pa.push_back(v[kPressure]);
    file.moving.push_back(!rows->has(kMoving) || v[kMoving] > 0.5);
    return {};
  };
  if (rows->for_each(take, file.problems) == 0) return no_content("sample", source, file.problems);
  return file;
}

/// The table as text of the same columns, preceded by a time where it has none.
std::string as_text(const FloatTable& table, double period_s) {
  std::string out;
  out.reserve(table.values.size() * 12);
  for (std::size_t r = 0; r < table.rows(); ++r) {
    if (period_s > 0.0) append_time(out, LogTime::from_seconds(static_cast<double>(r) * period_s));
    for (const float value : table.row(r)) {
      if (!out.empty() && out.back() != '\n') out += ' ';
      text::append_number(out, value);
    }
    out += '\n';
  }
  return out;
}

Result<MargFile> parse_table(std::string_view bytes, const std::string& source,
                             const MargFormat& format) {
  const Result<FloatTable> table = parse_float_table(bytes, source);
  if (!table) return table.error();
  if (!(format.period_s >= 0.0 && std::isfinite(format.period_s)))
    return Error{ErrorCode::invalid, "the sampling period is negative or not finite", source};
  ColumnFormat columns = format.columns;
  if (columns.columns.size() != table->columns)
    return Error{ErrorCode::invalid,
                 "has " + std::to_string(table->columns) + " columns without names; " +
                     std::to_string(columns.columns.size()) + " names are given",
                 source};
  if (format.period_s > 0.0) columns.columns.insert(columns.columns.begin(), "t_s");
  Result<MargFile> file = parse_rows(as_text(*table, format.period_s), source, columns);
  if (file)
    for (const Error& e : table->problems.first()) file->problems.add(e);
  return file;
}

}  // namespace

Result<MargFile> parse_marg(std::string_view bytes, const std::string& source,
                            const MargFormat& format) {
  if (bytes.starts_with(kTableMagic)) return parse_table(bytes, source, format);
  return parse_rows(bytes, source, format.columns);
}

Result<MargFile> read_marg(const std::string& path, const MargFormat& format) {
  return read_and_parse(path, {}, parse_marg, format);
}

std::string format_marg(std::span<const MargSample> samples) {
  const bool magnetometer = std::any_of(samples.begin(), samples.end(), [](const MargSample& s) {
    return s.magnetic_field_uT.allFinite();
  });
  std::string out = "t_s gx_radps gy_radps gz_radps ax_mps2 ay_mps2 az_mps2";
  out += magnetometer ? " mx_uT my_uT mz_uT\n" : "\n";
  for (const MargSample& s : samples) {
    append_time(out, s.time);
    append_numbers(out, s.angular_rate_radps);
    append_numbers(out, s.specific_force_mps2);
    if (magnetometer) append_numbers(out, s.magnetic_field_uT);
    out += '\n';
  }
  return out;
}

}  // namespace wayfare::io
