#pragma once

// The parts of ROS messages as plain values: stamp, header, and the contents of geometry_msgs and
// tf2_msgs. Every struct lists its fields once, in `fields`, in the order of its published
// definition; writing, reading and describing a message use that list.

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace wayfare::ros {

/// A published message type: its ROS 1 name (`sensor_msgs/Imu`, in ROS 2 `sensor_msgs/msg/Imu`),
/// the MD5 sum by which ROS 1 distinguishes versions (empty: only ever part of others) and the
/// constants at the beginning of its definition.
struct MessageType {
  std::string_view name;
  std::string_view md5 = {};
  std::string_view constants = {};
};

/// Seconds and nanoseconds of the sender's clock; both zero if not set.
struct Stamp {
  std::int64_t sec = 0;  ///< 32 bits in the message: unsigned in ROS 1, signed in ROS 2
  std::uint32_t nanosec = 0;

  friend bool operator==(const Stamp&, const Stamp&) = default;
};

struct Header {
  static constexpr MessageType kType{"std_msgs/Header", "2176decaecbce78abc3b96ef049fabed"};
  std::uint32_t seq = 0;  ///< ROS 1 only
  Stamp stamp;
  std::string frame_id = {};

  static void fields(auto& m, auto& a) {
    a.ros1_only("seq", m.seq), a("stamp", m.stamp), a("frame_id", m.frame_id);
  }
};

struct Vector3 {
  static constexpr MessageType kType{"geometry_msgs/Vector3"};
  double x = 0.0, y = 0.0, z = 0.0;

  static void fields(auto& m, auto& a) { a("x", m.x), a("y", m.y), a("z", m.z); }
};

struct Point {
  static constexpr MessageType kType{"geometry_msgs/Point"};
  double x = 0.0, y = 0.0, z = 0.0;

  static void fields(auto& m, auto& a) { a("x", m.x), a("y", m.y), a("z", m.z); }
};

struct Quaternion {
  static constexpr MessageType kType{"geometry_msgs/Quaternion"};
  double x = 0.0, y = 0.0, z = 0.0, w = 0.0;

  static void fields(auto& m, auto& a) { a("x", m.x), a("y", m.y), a("z", m.z), a("w", m.w); }
};

struct Pose {
  static constexpr MessageType kType{"geometry_msgs/Pose"};
  Point position;
  Quaternion orientation;

  static void fields(auto& m, auto& a) {
    a("position", m.position), a("orientation", m.orientation);
  }
};

struct PoseStamped {
  static constexpr MessageType kType{"geometry_msgs/PoseStamped",
                                     "d3812c3cbc69362b77dc0b19b345f8f5"};
  Header header;
  Pose pose;

  static void fields(auto& m, auto& a) { a("header", m.header), a("pose", m.pose); }
};

/// Covariance row by row of x, y, z and rotations about x, y, z.
struct PoseWithCovariance {
  static constexpr MessageType kType{"geometry_msgs/PoseWithCovariance"};
  Pose pose;
  std::array<double, 36> covariance = {};

  static void fields(auto& m, auto& a) { a("pose", m.pose), a("covariance", m.covariance); }
};

struct Twist {
  static constexpr MessageType kType{"geometry_msgs/Twist"};
  Vector3 linear, angular;

  static void fields(auto& m, auto& a) { a("linear", m.linear), a("angular", m.angular); }
};

struct TwistWithCovariance {
  static constexpr MessageType kType{"geometry_msgs/TwistWithCovariance"};
  Twist twist;
  std::array<double, 36> covariance = {};

  static void fields(auto& m, auto& a) { a("twist", m.twist), a("covariance", m.covariance); }
};

struct TransformParts {
  static constexpr MessageType kType{"geometry_msgs/Transform"};
  Vector3 translation;
  Quaternion rotation;

  static void fields(auto& m, auto& a) {
    a("translation", m.translation), a("rotation", m.rotation);
  }
};

/// The pose of `child_frame_id` in `header.frame_id`.
struct TransformStamped {
  static constexpr MessageType kType{"geometry_msgs/TransformStamped"};
  Header header;
  std::string child_frame_id = {};
  TransformParts transform;

  static void fields(auto& m, auto& a) {
    a("header", m.header), a("child_frame_id", m.child_frame_id), a("transform", m.transform);
  }
};

struct TfMessage {
  static constexpr MessageType kType{"tf2_msgs/TFMessage", "94810edda583a504dfda3829e70d7eec"};
  std::vector<TransformStamped> transforms = {};

  static void fields(auto& m, auto& a) { a("transforms", m.transforms); }
};

}  // namespace wayfare::ros
