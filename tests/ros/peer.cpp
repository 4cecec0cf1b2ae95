#include "peer.hpp"

#include <geometry_msgs/PoseArray.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <nav_msgs/OccupancyGrid.h>
#include <nav_msgs/Odometry.h>
#include <nav_msgs/Path.h>
#include <ros/serialization.h>
#include <rosgraph_msgs/Clock.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/JointState.h>
#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/MagneticField.h>
#include <sensor_msgs/NavSatFix.h>
#include <sensor_msgs/PointCloud2.h>
#include <std_msgs/String.h>
#include <tf2_msgs/TFMessage.h>

#include <stdexcept>

namespace peer {
namespace {

template <class M>
std::string again(std::string bytes) {
  namespace wire = ros::serialization;
  M message;
  wire::IStream in(reinterpret_cast<std::uint8_t*>(&bytes[0]),
                   static_cast<std::uint32_t>(bytes.size()));
  wire::deserialize(in, message);
  if (in.getLength() != 0) throw std::length_error("bytes are left");
  const auto out = wire::serializeMessage(message);
  return std::string(reinterpret_cast<const char*>(out.message_start), out.num_bytes - 4);
}

/// Calls `visit` with an empty message of each supported type, until it returns true.
template <class Visit>
bool any_message(Visit visit) {
  return visit(std_msgs::Header()) || visit(sensor_msgs::LaserScan()) ||
         visit(sensor_msgs::PointCloud2()) || visit(sensor_msgs::Imu()) ||
         visit(sensor_msgs::MagneticField()) || visit(sensor_msgs::NavSatFix()) ||
         visit(nav_msgs::Odometry()) || visit(nav_msgs::Path()) ||
         visit(nav_msgs::OccupancyGrid()) || visit(geometry_msgs::PoseStamped()) ||
         visit(geometry_msgs::PoseWithCovarianceStamped()) || visit(tf2_msgs::TFMessage()) ||
         visit(sensor_msgs::JointState()) || visit(std_msgs::String()) ||
         visit(rosgraph_msgs::Clock()) || visit(geometry_msgs::PoseArray());
}

template <class M>
bool is(const M&, const std::string& name) {
  return name == ros::message_traits::datatype<M>();
}

}  // namespace

Kind kind_of(const std::string& name) {
  namespace traits = ros::message_traits;
  Kind kind;
  any_message([&](const auto& m) {
    if (!is(m, name)) return false;
    using M = std::decay_t<decltype(m)>;
    kind = {traits::datatype<M>(), traits::md5sum<M>(), traits::definition<M>()};
    return true;
  });
  return kind;
}

std::string written_again(const std::string& name, const std::string& bytes) {
  std::string out;
  any_message([&](const auto& m) {
    if (!is(m, name)) return false;
    out = again<std::decay_t<decltype(m)>>(bytes);
    return true;
  });
  return out;
}

}  // namespace peer
