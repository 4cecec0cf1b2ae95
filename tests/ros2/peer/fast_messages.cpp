#include "fast_messages.hpp"

#include <algorithm>
#include <stdexcept>

#include <fastdds/dds/topic/TypeSupport.hpp>

#include "formula.hpp"
#include "ros_messages.h"
#include "ros_messagesPubSubTypes.h"

namespace peer {
namespace {

namespace dds = eprosima::fastdds::dds;

template <class F, class... Fields>
void each_of(F& formula, Fields&... fields) {
  (formula(fields), ...);
}

/// The fields of the generated types, in the order of their definitions.
struct FastFields {
  template <class F, class M>
  static void each(F& formula, M& message) {
    fields(formula, message);
  }

 private:
  template <class F>
  static void fields(F& f, builtin_interfaces::msg::dds_::Time_& m) {
    each_of(f, m.sec(), m.nanosec());
  }
  template <class F>
  static void fields(F& f, std_msgs::msg::dds_::Header_& m) {
    each_of(f, m.stamp(), m.frame_id());
  }
  template <class F>
  static void fields(F& f, rosgraph_msgs::msg::dds_::Clock_& m) {
    each_of(f, m.clock());
  }
  template <class F>
  static void fields(F& f, geometry_msgs::msg::dds_::Vector3_& m) {
    each_of(f, m.x(), m.y(), m.z());
  }
  template <class F>
  static void fields(F& f, geometry_msgs::msg::dds_::Point_& m) {
    each_of(f, m.x(), m.y(), m.z());
  }
  template <class F>
  static void fields(F& f, geometry_msgs::msg::dds_::Quaternion_& m) {
    each_of(f, m.x(), m.y(), m.z(), m.w());
  }
  template <class F>
  static void fields(F& f, geometry_msgs::msg::dds_::Pose_& m) {
    each_of(f, m.position(), m.orientation());
  }
  template <class F>
  static void fields(F& f, geometry_msgs::msg::dds_::PoseArray_& m) {
    each_of(f, m.header(), m.poses());
  }
  template <class F>
  static void fields(F& f, geometry_msgs::msg::dds_::PoseWithCovariance_& m) {
    each_of(f, m.pose(), m.covariance());
  }
  template <class F>
  static void fields(F& f, geometry_msgs::msg::dds_::PoseWithCovarianceStamped_& m) {
    each_of(f, m.header(), m.pose());
  }
  template <class F>
  static void fields(F& f, geometry_msgs::msg::dds_::Twist_& m) {
    each_of(f, m.linear(), m.angular());
  }
  template <class F>
  static void fields(F& f, geometry_msgs::msg::dds_::TwistWithCovariance_& m) {
    each_of(f, m.twist(), m.covariance());
  }
  template <class F>
  static void fields(F& f, geometry_msgs::msg::dds_::Transform_& m) {
    each_of(f, m.translation(), m.rotation());
  }
  template <class F>
  static void fields(F& f, geometry_msgs::msg::dds_::TransformStamped_& m) {
    each_of(f, m.header(), m.child_frame_id(), m.transform());
  }
  template <class F>
  static void fields(F& f, tf2_msgs::msg::dds_::TFMessage_& m) {
    each_of(f, m.transforms());
  }
  template <class F>
  static void fields(F& f, sensor_msgs::msg::dds_::LaserScan_& m) {
    each_of(f, m.header(), m.angle_min(), m.angle_max(), m.angle_increment(), m.time_increment());
    each_of(f, m.scan_time(), m.range_min(), m.range_max(), m.ranges(), m.intensities());
  }
  template <class F>
  static void fields(F& f, sensor_msgs::msg::dds_::PointField_& m) {
    each_of(f, m.name(), m.offset(), m.datatype(), m.count());
  }
  template <class F>
  static void fields(F& f, sensor_msgs::msg::dds_::PointCloud2_& m) {
    each_of(f, m.header(), m.height(), m.width(), m.fields(), m.is_bigendian(), m.point_step());
    each_of(f, m.row_step(), m.data(), m.is_dense());
  }
  template <class F>
  static void fields(F& f, sensor_msgs::msg::dds_::Imu_& m) {
    each_of(f, m.header(), m.orientation(), m.orientation_covariance(), m.angular_velocity());
    each_of(f, m.angular_velocity_covariance(), m.linear_acceleration());
    each_of(f, m.linear_acceleration_covariance());
  }
  template <class F>
  static void fields(F& f, nav_msgs::msg::dds_::MapMetaData_& m) {
    each_of(f, m.map_load_time(), m.resolution(), m.width(), m.height(), m.origin());
  }
  template <class F>
  static void fields(F& f, nav_msgs::msg::dds_::OccupancyGrid_& m) {
    each_of(f, m.header(), m.info(), m.data());
  }
  template <class F>
  static void fields(F& f, nav_msgs::msg::dds_::Odometry_& m) {
    each_of(f, m.header(), m.child_frame_id(), m.pose(), m.twist());
  }
};

}  // namespace

struct FastMessage::Kind {
  std::string name;
  dds::TypeSupport type;
  std::string (*visit)(void* message, std::uint32_t sample, std::uint32_t size, bool compares);
};

namespace {

template <class M>
std::string visit(void* message, std::uint32_t sample, std::uint32_t size, bool compares) {
  Formula<FastFields> formula(sample, size, compares);
  formula(*static_cast<M*>(message));
  return formula.difference();
}

}  // namespace

const std::vector<FastMessage::Kind>& FastMessage::kinds() {
  namespace s = sensor_msgs::msg::dds_;
  namespace n = nav_msgs::msg::dds_;
  namespace g = geometry_msgs::msg::dds_;
  static const std::vector<Kind> all = {
      {"sensor_msgs/msg/LaserScan", dds::TypeSupport(new s::LaserScan_PubSubType),
       visit<s::LaserScan_>},
      {"sensor_msgs/msg/PointCloud2", dds::TypeSupport(new s::PointCloud2_PubSubType),
       visit<s::PointCloud2_>},
      {"sensor_msgs/msg/Imu", dds::TypeSupport(new s::Imu_PubSubType), visit<s::Imu_>},
      {"nav_msgs/msg/Odometry", dds::TypeSupport(new n::Odometry_PubSubType), visit<n::Odometry_>},
      {"tf2_msgs/msg/TFMessage", dds::TypeSupport(new tf2_msgs::msg::dds_::TFMessage_PubSubType),
       visit<tf2_msgs::msg::dds_::TFMessage_>},
      {"nav_msgs/msg/OccupancyGrid", dds::TypeSupport(new n::OccupancyGrid_PubSubType),
       visit<n::OccupancyGrid_>},
      {"geometry_msgs/msg/PoseWithCovarianceStamped",
       dds::TypeSupport(new g::PoseWithCovarianceStamped_PubSubType),
       visit<g::PoseWithCovarianceStamped_>},
      {"geometry_msgs/msg/PoseArray", dds::TypeSupport(new g::PoseArray_PubSubType),
       visit<g::PoseArray_>},
      {"rosgraph_msgs/msg/Clock", dds::TypeSupport(new rosgraph_msgs::msg::dds_::Clock_PubSubType),
       visit<rosgraph_msgs::msg::dds_::Clock_>},
  };
  return all;
}

std::vector<std::string> type_names() {
  std::vector<std::string> names;
  for (const auto& kind : FastMessage::kinds()) names.push_back(kind.name);
  return names;
}

FastMessage::FastMessage(const std::string& type)
    : kind_([&]() -> const Kind& {
        const auto found = std::find_if(kinds().begin(), kinds().end(),
                                        [&](const Kind& kind) { return kind.name == type; });
        if (found == kinds().end()) throw std::invalid_argument("no type '" + type + "'");
        return *found;
      }()),
      data_(dds::TypeSupport(kind_.type)->createData()) {}

FastMessage::~FastMessage() { dds::TypeSupport(kind_.type)->deleteData(data_); }

const dds::TypeSupport& FastMessage::type() const { return kind_.type; }

void FastMessage::fill(std::uint32_t sample, std::uint32_t size) {
  kind_.visit(data_, sample, size, false);
}

std::string FastMessage::difference(std::uint32_t sample, std::uint32_t size) {
  return kind_.visit(data_, sample, size, true);
}

std::string FastMessage::to_bytes() {
  dds::TypeSupport type = kind_.type;
  eprosima::fastrtps::rtps::SerializedPayload_t payload(type->getSerializedSizeProvider(data_)());
  if (!type->serialize(data_, &payload)) return {};
  return {reinterpret_cast<const char*>(payload.data), payload.length};
}

bool FastMessage::from_bytes(const std::string& bytes) {
  dds::TypeSupport type = kind_.type;
  eprosima::fastrtps::rtps::SerializedPayload_t payload(static_cast<std::uint32_t>(bytes.size()));
  std::copy(bytes.begin(), bytes.end(), reinterpret_cast<char*>(payload.data));
  payload.length = static_cast<std::uint32_t>(bytes.size());
  try {
    return type->deserialize(&payload, data_);
  } catch (const std::exception&) {
    return false;
  }
}

}  // namespace peer
