#include "recording.hpp"

#include <cstddef>
#include <cstdio>
#include <utility>

#include <wayfare/logger/read_recording.hpp>

#include "support/command_line.hpp"
#include "support/ros_topics.hpp"

namespace wayfare::examples {
namespace {

template <class Path>
void add_existing(CommandLine& app, const std::string& name, Path& path) {
  app.add_option(
         name, path,
         "columns of text, a binary table, a ROS recording (ROS 2's .mcap, ROS 1's .bag), or a "
         "logger's recording (.mcap)")
      .required()
      .existing_file();
}

}  // namespace

void RecordingOptions::add_path(CommandLine& app, const std::string& name, std::string& path) {
  add_existing(app, name, path);
}
void RecordingOptions::add_path(CommandLine& app, const std::string& name,
                                std::vector<std::string>& paths) {
  add_existing(app, name, paths);
}

void RecordingOptions::describe(CommandLine& app) {
  describe_beside_log(app);
  add_stamps(app, topics);
}

void RecordingOptions::describe_beside_log(CommandLine& app) {
  app.add_option("--columns", columns,
                 "names of the columns, set apart by commas, for a file that does not name them: "
                 "t_s, gx_radps.., ax_mps2.., mx_uT.., qw qx qy qz (reference), moving; - passes "
                 "one over")
      .delimiter(',');
  app.add_option("--period", period_s, "seconds from row to row, for a binary table without a time")
      .positive();
  app.add_option("--topic", topic, "of the unit in a recording (.mcap, .bag) of several");
  add_unit_topics(app, topics);
}

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

/// A unit in a logger's recording.
Result<io::MargFile> read_logged(const std::string& path, const std::string& topic) {
  auto logged = logger::read_marg_recording(path, topic);
  if (!logged) return logged.error();
  return file_of(std::move(logged->samples), std::move(logged->problems));
}

/// A unit in a ROS recording.
Result<io::MargFile> read_ros(const std::string& path, const ros::TopicNames& names,
                              std::optional<SO3d>* q_base_unit) {
  const auto recording = ros::RecordingFile::open(path);
  if (!recording) return recording.error();
  auto run = ros::read_marg(*recording, names);
  if (!run) return run.error();
  if (q_base_unit != nullptr) *q_base_unit = run->q_base_unit;
  return file_of(std::move(run->samples), std::move(run->problems));
}

}  // namespace

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
  if (!file) return file;
  constexpr std::size_t kShown = 5;
  const io::Problems& problems = file->problems;
  for (std::size_t i = 0; i < problems.first().size() && i < kShown; ++i)
    std::fprintf(stderr, "skipped: %s\n", problems.first()[i].to_string().c_str());
  if (problems.count() > kShown)
    std::fprintf(stderr, "skipped: %zu lines in all\n", problems.count());
  return file;
}

void FilterOptions::describe(CommandLine& app) {
  app.add_flag("--enu", enu, "attitude in east-north-up instead of north-east-down");
  app.add_flag("--no-magnetometer", no_magnetometer, "gyro and accelerometer alone");
  app.add_option("--declination", declination_deg,
                 "of magnetic from true north, degrees, east positive")
      .range(-180.0, 180.0)
      .show_default();
  app.add_option("--magnetometer-delay", delay_s,
                 "how long after the field its reading is stamped, seconds; found by the filter "
                 "where not given")
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

}  // namespace wayfare::examples
