#include "unit_options.hpp"

#include <cmath>
#include <cstdio>
#include <utility>

#include <wayfare/logger/messages.hpp>

namespace wayfare::examples {

void UnitOptions::add_options(CommandLine& app) {
  app.add_option("--unit", path,
                 "the recording of the inertial unit, on the clock of LOG; by default the unit in "
                 "LOG, if it has one")
      .existing_file();
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

SO3d UnitOptions::q_base_unit(const UnitReadings& readings, const Recording& log) const {
  if (readings.q_base_unit) return *readings.q_base_unit;
  return SO3d::exp(Eigen::Vector3d(0, 0, log.T_base_laser.raw().heading().radians())) *
         q_unit_laser().inverse();
}

}  // namespace wayfare::examples
