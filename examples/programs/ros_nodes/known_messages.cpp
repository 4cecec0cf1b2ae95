#include "known_messages.hpp"

#include <tuple>

namespace wayfare::examples {
namespace {

template <class M>
Result<std::string> converted(std::string_view bytes, ros::Dialect from, ros::Dialect to) {
  if (from == to) return std::string(bytes);
  const auto message = ros::from_bytes<M>(bytes, from);
  if (!message) return message.error();
  return ros::to_bytes(*message, to);
}

template <class... M>
std::map<std::string, MessageKind> kinds(std::tuple<M...>*) {
  return {
      {std::string(M::kType.name),
       MessageKind{ros::topic_type<M>(), ros::definition<M>(ros::Dialect::ros2), converted<M>}}...};
}

using Known =
    std::tuple<ros::LaserScan, ros::Odometry, ros::Imu, ros::MagneticField, ros::NavSatFix,
               ros::PointCloud2, ros::RadarScan, ros::TfMessage, ros::PoseStamped,
               ros::PoseWithCovarianceStamped, ros::JointState, ros::String, ros::Path,
               ros::OccupancyGrid, ros::Clock, ros::PoseArray, ros::ParticleCloud>;

}  // namespace

const std::map<std::string, MessageKind>& known_messages() {
  static const auto all = kinds(static_cast<Known*>(nullptr));
  return all;
}

}  // namespace wayfare::examples
