// Noise of an inertial unit from a long recording at rest: nominal parameters of a filter.

#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <numbers>
#include <string>

#include <wayfare/io/text_file.hpp>
#include <wayfare/ros/recording.hpp>

#include "findings.hpp"
#include "support/nav_config.hpp"
#include "support/program_files.hpp"
#include "support/ros_topics.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

struct RecordFormat {
  double rate_hz = 0.0;  ///< 0: from the file's times
  /// A table of float32 without header: gx gy gz in deg/s, ax ay az in g.
  bool raw = false;
  ros::TopicNames topics = {};  ///< of a ROS recording
};

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

/// From text columns as for gnss_ins, a ROS recording, a float table, or raw float32.
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

struct Options : OutputArguments {
  std::string file, config;
  RecordFormat format;
};

constexpr const char* kParameters = "parameters.json";
constexpr const char* kReport = "report.html";

Result<void> write_parameters(const Options& o, const UnitFit& fit) {
  auto config = read_nav_config(o.config);
  if (!config) return config.error();
  config->note = "imu_noise from " + o.file + " at rest; scale factors are not observable at rest";
  config->filter.imu = nominal_noise(fit);
  return io::write_file(o.path(kParameters), format_nav_config(*config), o.write());
}

Result<void> write(const Options& o, const RestRecord& record, const UnitFit& fit) {
  io::Report report("Noise of an inertial unit at rest",
                    o.file + ": " + std::to_string(record.readings) + " samples, " +
                        eval::fixed(record.rate_hz, 1) + " per second, " +
                        eval::fixed(record.length_s() / 3600.0, 2) + " h");
  report.table(allan_table(fit),
               "Components of the Allan variance and the times where they dominate");
  report.table(gauss_markov_table(fit), "Slow errors from the autocorrelation");
  for (const std::string& remark : remarks(fit)) report.paragraph(remark);
  for (const io::Plot& plot : allan_plots(fit)) report.plot(plot);
  auto done = first_error(
      {o.out.empty() ? Result<void>{} : write_parameters(o, fit), o.write_report(report)});
  if (done && !o.quiet && !o.out.empty())
    std::printf("parameters: %s\nreport: %s\n", o.path(kParameters).c_str(),
                o.path(kReport).c_str());
  return done;
}

void print(const Options& o, const RestRecord& record, const UnitFit& fit) {
  std::printf("%s: %zu readings, %.3f per second, %.2f h\n\n%s\n%s\n", o.file.c_str(),
              record.readings, record.rate_hz, record.length_s() / 3600.0,
              allan_table(fit).to_text().c_str(), gauss_markov_table(fit).to_text().c_str());
  for (const std::string& remark : remarks(fit)) std::printf("%s\n", remark.c_str());
}

Result<void> run(const Options& o) {
  if (auto ready = o.prepare({kParameters, kReport}); !ready) return ready;
  const auto record = read_rest_record(o.file, o.format);
  if (!record) return record.error();
  const UnitFit fit = fit_unit(*record);
  if (!o.quiet) print(o, *record, fit);
  return o.wants_report() ? write(o, *record, fit) : Result<void>{};
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine app(
      "Noise of an inertial unit from a long recording at rest: Allan deviation and Gauss-Markov "
      "fits for each axis. With --out a report with the curves, and parameters.json for gnss_ins "
      "--config.");
  Options o;
  app.add_file("FILE", o.file,
               "columns of text, a float table, or raw float32, gzip or not; or a ROS recording "
               "(ROS 2's .mcap, ROS 1's .bag)")
      .required();
  app.add_number("--rate", o.format.rate_hz, 0.0, 1e6,
                 "samples per second; 0: from the times in the file");
  app.add_flag("--raw", o.format.raw, "rows of six float32: gx gy gz in deg/s, ax ay az in g");
  add_imu_topic(app, o.format.topics);
  app.add_option("--out", o.out, kResultsFolder).shown_as("DIR");
  app.add_file("--config", o.config, "mounting and filter options for parameters.json");
  add_force_and_quiet(app, o);
  add_json(app, o);
  app.example("rest.csv", "prints deviations and fits of a unit at rest");
  app.example("rest.bag --imu-topic /imu --out noise",
              "the same of a ROS recording, with parameters.json for gnss_ins");
  if (const auto code = app.parse(argc, argv)) return *code;
  return exit_code("allan", run(o));
}
