#include "record.hpp"

#include <cmath>
#include <cstring>
#include <numbers>

#include <wayfare/io/columns.hpp>
#include <wayfare/ros/recording.hpp>

#include "support/program_files.hpp"

namespace wayfare::examples {
namespace {

constexpr std::size_t kAxes = 6;
constexpr double kDegree = std::numbers::pi / 180.0, kG = 9.80665;

RestRecord start(double rate_hz) {
  RestRecord r;
  r.rate_hz = rate_hz;
  for (std::size_t i = 0; i < kAxes; ++i)
    r.axes.push_back({AllanRecorder(1.0 / rate_hz), AutocorrelationRecorder(1.0 / rate_hz)});
  return r;
}

template <class Value>
void add(RestRecord& record, const Value& value) {
  for (std::size_t i = 0; i < kAxes; ++i) {
    record.axes[i].allan.add(value(i));
    record.axes[i].slow.add(value(i));
  }
  ++record.readings;
}

double in_si(std::size_t axis, float v) {
  return static_cast<double>(v) * (axis < 3 ? kDegree : kG);
}

Result<RestRecord> from_rows(const char* bytes, std::size_t rows, const std::string& path,
                             const RecordFormat& format) {
  if (!(format.rate_hz > 0.0))
    return Error{ErrorCode::invalid, "has no times: --rate must give the sampling rate", path};
  RestRecord record = start(format.rate_hz);
  for (std::size_t r = 0; r < rows; ++r) {
    std::array<float, kAxes> row;
    std::memcpy(row.data(), bytes + r * sizeof row, sizeof row);
    add(record, [&row](std::size_t i) { return in_si(i, row[i]); });
  }
  return record;
}

Result<RestRecord> from_samples(const std::string& path, const RecordFormat& format) {
  const auto file = ros::read_imu(path, {}, format.topics);
  if (!file) return file.error();
  print_problems(file->problems);
  if (!file->has_gyro || !file->has_accelerometer || file->samples.size() < 2)
    return Error{ErrorCode::invalid, "must contain gyro and accelerometer readings", path};
  const double span = to_seconds(file->samples.back().time - file->samples.front().time);
  const double rate =
      format.rate_hz > 0.0 ? format.rate_hz : static_cast<double>(file->samples.size() - 1) / span;
  if (!(rate > 0.0) || !std::isfinite(rate))
    return Error{ErrorCode::invalid, "has times that do not increase", path};
  RestRecord record = start(rate);
  for (const ImuSample& s : file->samples) {
    add(record, [&s](std::size_t i) {
      const auto k = static_cast<Eigen::Index>(i % 3);
      return i < 3 ? s.angular_rate_radps[k] : s.specific_force_mps2[k];
    });
  }
  return record;
}

}  // namespace

Result<RestRecord> read_rest_record(const std::string& path, const RecordFormat& format) {
  if (ros::RecordingFile::is_one(path)) return from_samples(path, format);
  const auto file = io::read_file(path);
  if (!file) return file.error();
  constexpr std::size_t kRow = kAxes * sizeof(float);
  if (file->bytes.starts_with("F32 ")) {
    const auto table = io::parse_float_table(file->bytes, path);
    if (!table) return table.error();
    if (table->columns != kAxes)
      return Error{ErrorCode::invalid, "must have six columns: gx gy gz [deg/s] ax ay az [g]",
                   path};
    return from_rows(reinterpret_cast<const char*>(table->values.data()), table->rows(), path,
                     format);
  }
  if (!format.raw) return from_samples(path, format);
  if (file->bytes.size() < kRow || file->bytes.size() % kRow != 0)
    return Error{ErrorCode::parse, "is not a whole number of rows of six float32", path};
  return from_rows(file->bytes.data(), file->bytes.size() / kRow, path, format);
}

}  // namespace wayfare::examples
