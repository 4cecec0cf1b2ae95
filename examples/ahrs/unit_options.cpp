#include "unit_options.hpp"

#include <cmath>

namespace wayfare::examples {

Option UnitOptions::describe(CommandLine& app) {
  Option unit =
      app.add_option("--unit", path, "the recording of the inertial unit, on the same clock as LOG")
          .existing_file();
  recording.describe_beside_log(app);
  app.add_option("--forward", forward, "the unit's axis along which the laser's x points")
      .one_of({"x", "y", "-x", "-y"})
      .show_default();
  return unit;
}

Result<io::MargFile> UnitOptions::read(const ros::TopicNames& log) const {
  RecordingOptions as_log = recording;
  as_log.topics.stamps = log.stamps;
  return as_log.read(path);
}

Eigen::Vector3d UnitOptions::forward_axis() const {
  return (forward[0] == '-' ? -1.0 : 1.0) * Eigen::Vector3d::Unit(forward.back() - 'x');
}

SO3d UnitOptions::q_unit_laser() const {
  const Eigen::Vector3d axis = forward_axis();
  return SO3d::exp(Eigen::Vector3d(0, 0, std::atan2(axis.y(), axis.x())));
}

}  // namespace wayfare::examples
