#include "recording.hpp"

#include <cmath>
#include <cstddef>
#include <cstdio>
#include <utility>

#include <nlohmann/json.hpp>

#include <wayfare/logger/messages.hpp>

#include "support/json_object.hpp"
#include "support/program_files.hpp"
#include "support/ros_topics.hpp"

namespace wayfare::examples {
namespace {

io::MargFile file_of(MargRecording samples, io::Problems problems) {
  io::MargFile file;
  file.samples = std::move(samples);
  file.moving.assign(file.samples.size(), true);
  file.problems = std::move(problems);
  for (const MargSample& s : file.samples)
    file.has_magnetometer = file.has_magnetometer || s.magnetic_field_uT.allFinite();
  return file;
}

/// From a logger's recording.
Result<io::MargFile> read_logged(const std::string& path, const std::string& topic) {
  auto logged = logger::read_marg_recording(path, topic);
  if (!logged) return logged.error();
  return file_of(std::move(logged->samples), std::move(logged->problems));
}

/// From a ROS recording.
Result<io::MargFile> read_ros(const std::string& path, const ros::TopicNames& names,
                              std::optional<SO3d>* q_base_unit) {
  const auto recording = ros::RecordingFile::open(path);
  if (!recording) return recording.error();
  auto run = ros::read_marg(*recording, names);
  if (!run) return run.error();
  if (q_base_unit != nullptr) *q_base_unit = run->q_base_unit;
  return file_of(std::move(run->samples), std::move(run->problems));
}

using Json = nlohmann::json;

template <class Matrix>
Json rows_of(const Matrix& m) {
  Json rows = Json::array();
  for (int r = 0; r < m.rows(); ++r) {
    Json row = Json::array();
    for (int c = 0; c < m.cols(); ++c) row.push_back(m(r, c));
    rows.push_back(m.cols() == 1 ? row[0] : row);
  }
  return rows;
}

/// Three finite numbers.
bool read_triple(const Json& from, Eigen::Vector3d& to) {
  if (!from.is_array() || from.size() != 3) return false;
  for (std::size_t i = 0; i < 3; ++i) {
    if (!from[i].is_number()) return false;
    to[static_cast<Eigen::Index>(i)] = from[i].get<double>();
  }
  return to.allFinite();
}

}  // namespace

void RecordingOptions::add_options(CommandLine& app) {
  add_options_beside_log(app);
  add_stamps(app, topics);
}

void RecordingOptions::add_options_beside_log(CommandLine& app) {
  app.add_option("--columns", columns,
                 "comma-separated names of the columns, for a file that does not name them: t_s, "
                 "gx_radps.., ax_mps2.., mx_uT.., qw qx qy qz (reference), moving; - skips one")
      .delimiter(',');
  app.add_option("--period", period_s, "seconds between rows, for a binary table without times")
      .positive();
  app.add_option("--topic", topic, "of the unit, in a recording (.mcap, .bag) of several units");
  add_unit_topics(app, topics);
}

Result<io::MargFile> RecordingOptions::read(const std::string& path,
                                            std::optional<SO3d>* q_base_unit) const {
  io::MargFormat format;
  format.columns.columns = columns;
  format.period_s = period_s;
  ros::TopicNames names = topics;
  names.imu = topic;
  auto file = ros::RecordingFile::is_one(path) ? read_ros(path, names, q_base_unit)
              : logger::is_recording(path)     ? read_logged(path, topic)
                                               : io::read_marg(path, format);
  if (file) print_problems(file->problems);
  return file;
}

void FilterOptions::add_options(CommandLine& app) {
  app.add_flag("--enu", enu, "attitude in east-north-up instead of north-east-down");
  app.add_flag("--no-magnetometer", no_magnetometer, "use gyro and accelerometer alone");
  app.add_number("--declination", declination_deg, -180.0, 180.0,
                 "of magnetic from true north, degrees, east positive");
  app.add_option("--magnetometer-delay", delay_s,
                 "delay of the magnetometer's time stamps, seconds; by default estimated")
      .range(-0.1, 0.1);
}

AhrsParameters FilterOptions::parameters() const {
  AhrsParameters p;
  p.use_magnetometer = !no_magnetometer;
  p.declination = Angle::degrees(declination_deg);
  if (delay_s) {
    p.magnetometer_delay_s = *delay_s;
    p.magnetometer_delay_sigma_s = 0.0;
  }
  return p;
}

void UnitOptions::add_options(CommandLine& app) {
  app.add_file("--unit", path,
               "the recording of the inertial unit, on the clock of LOG; by default the unit in "
               "LOG, if it has one");
  recording.add_options_beside_log(app);
  app.add_option("--forward", forward,
                 "the unit's axis along which the laser's x points, unless a ROS recording has the "
                 "transform")
      .one_of({"x", "y", "-x", "-y"})
      .show_default();
}

Result<std::optional<UnitReadings>> UnitOptions::read(const std::string& log,
                                                      const ros::TopicNames& topics) const {
  using Readings = std::optional<UnitReadings>;
  const bool own = path.empty();
  if (none || (own && !ros::RecordingFile::is_one(log) && !logger::is_recording(log)))
    return Readings();
  RecordingOptions as_log = recording;
  as_log.topics.stamps = topics.stamps;
  as_log.topics.base_frame = topics.base_frame;
  if (own && as_log.topic.empty()) as_log.topic = topics.imu;
  UnitReadings readings;
  auto file = as_log.read(own ? log : path, &readings.q_base_unit);
  if (!file && own && as_log.topic.empty()) {
    // It was not requested: a log with a gyro alone, or with several units, is no error.
    if (file.error().code != ErrorCode::not_found)
      std::fprintf(stderr, "the inertial unit in the log is not used: %s\n",
                   file.error().to_string().c_str());
    return Readings();
  }
  if (!file) return file.error();
  readings.file = *std::move(file);
  return Readings(std::move(readings));
}

Eigen::Vector3d UnitOptions::forward_axis() const {
  return (forward[0] == '-' ? -1.0 : 1.0) * Eigen::Vector3d::Unit(forward.back() - 'x');
}

SO3d UnitOptions::q_unit_laser() const {
  const Eigen::Vector3d axis = forward_axis();
  return SO3d::exp(Eigen::Vector3d(0, 0, std::atan2(axis.y(), axis.x())));
}

namespace {

SO3d q_base_laser(const Recording& log) {
  return SO3d::exp(Eigen::Vector3d(0, 0, log.T_base_laser.raw().heading().radians()));
}

}  // namespace

Eigen::Vector3d UnitOptions::forward_axis(const UnitReadings& readings,
                                          const Recording& log) const {
  if (!readings.q_base_unit) return forward_axis();
  return q_unit_laser(readings, log) * Eigen::Vector3d::UnitX();
}

SO3d UnitOptions::q_unit_laser(const UnitReadings& readings, const Recording& log) const {
  if (!readings.q_base_unit) return q_unit_laser();
  return readings.q_base_unit->inverse() * q_base_laser(log);
}

SO3d UnitOptions::q_base_unit(const UnitReadings& readings, const Recording& log) const {
  if (readings.q_base_unit) return *readings.q_base_unit;
  return q_base_laser(log) * q_unit_laser().inverse();
}

Result<MagnetometerCalibration> read_calibration(const std::string& path) {
  const auto content = io::read_file(path);
  if (!content) return content.error();
  const auto parsed = parse_json_object<Json>(content->bytes, path);
  if (!parsed) return parsed.error();
  const Json& json = *parsed;
  const auto error = [&](const char* what) { return Error{ErrorCode::parse, what, path}; };
  MagnetometerCalibration c;
  if (!json.contains("offset_uT") || !read_triple(json["offset_uT"], c.offset_uT))
    return error("needs 'offset_uT', three numbers");
  const bool square = json.contains("correction") && json["correction"].is_array() &&
                      json["correction"].size() == 3;
  for (std::size_t r = 0; r < 3; ++r) {
    Eigen::Vector3d row;
    if (!square || !read_triple(json["correction"][r], row))
      return error("needs 'correction', three rows of three numbers");
    c.correction.row(static_cast<Eigen::Index>(r)) = row.transpose();
  }
  return c;
}

Result<void> write_calibration(const std::string& path, const MagnetometerCalibration& c,
                               const io::WriteOptions& options) {
  const Json json{{"offset_uT", rows_of(c.offset_uT)},
                  {"correction", rows_of(c.correction)},
                  {"offset_sigma_uT", rows_of(c.offset_sigma_uT)},
                  {"correction_sigma", rows_of(c.correction_sigma)},
                  {"field_uT", c.field_uT},
                  {"residual_uT", c.residual_uT},
                  {"raw_residual_uT", c.raw_residual_uT},
                  {"readings", c.used}};
  return io::write_file(path, json.dump(2) + "\n", options);
}

}  // namespace wayfare::examples
