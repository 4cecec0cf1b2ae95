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
  std::string_view name;            ///< ROS 1 name
  std::string_view md5 = {};        ///< hexadecimal
  std::string_view constants = {};  ///< lines of the definition
};

/// Seconds and nanoseconds of the sender's clock; both zero if not set.
struct Stamp {
  std::int64_t sec = 0;       ///< 32 bits in the message: unsigned in ROS 1, signed in ROS 2
  std::uint32_t nanosec = 0;  ///< below 10⁹

  friend bool operator==(const Stamp&, const Stamp&) = default;  ///< of both parts
};

/// Stamp and frame of a message.
struct Header {
  static constexpr MessageType kType{"std_msgs/Header", "2176decaecbce78abc3b96ef049fabed"};
  std::uint32_t seq = 0;      ///< ROS 1 only
  Stamp stamp;                ///< of the measurement
  std::string frame_id = {};  ///< frame of the content
  static void fields(auto& m, auto& a) {
    a.ros1_only("seq", m.seq), a("stamp", m.stamp), a("frame_id", m.frame_id);
  }
};

/// A text.
struct String {
  static constexpr MessageType kType{"std_msgs/String", "992ce8a1687cec8c8bd883ec73ca41d1"};
  std::string data = {};  ///< the text
  static void fields(auto& m, auto& a) { a("data", m.data); }
};

/// The time of a simulation or a replay, on /clock.
struct Clock {
  static constexpr MessageType kType{"rosgraph_msgs/Clock", "a9c97c1d230cfc112e270351a944ee47"};
  Stamp clock;  ///< now
  static void fields(auto& m, auto& a) { a("clock", m.clock); }
};

/// A vector in the frame of its message.
struct Vector3 {
  static constexpr MessageType kType{"geometry_msgs/Vector3"};
  double x = 0.0,  ///< along x
      y = 0.0,     ///< along y
      z = 0.0;     ///< along z
  static void fields(auto& m, auto& a) { a("x", m.x), a("y", m.y), a("z", m.z); }
};

/// A position, m.
struct Point {
  static constexpr MessageType kType{"geometry_msgs/Point"};
  double x = 0.0,  ///< forward
      y = 0.0,     ///< left
      z = 0.0;     ///< up
  static void fields(auto& m, auto& a) { a("x", m.x), a("y", m.y), a("z", m.z); }
};

/// A rotation, a unit quaternion.
struct Quaternion {
  static constexpr MessageType kType{"geometry_msgs/Quaternion"};
  double x = 0.0,  ///< of i
      y = 0.0,     ///< of j
      z = 0.0,     ///< of k
      w = 0.0;     ///< scalar part
  static void fields(auto& m, auto& a) { a("x", m.x), a("y", m.y), a("z", m.z), a("w", m.w); }
};

/// Position and orientation.
struct Pose {
  static constexpr MessageType kType{"geometry_msgs/Pose"};
  Point position;          ///< m
  Quaternion orientation;  ///< rotation
  static void fields(auto& m, auto& a) {
    a("position", m.position), a("orientation", m.orientation);
  }
};

/// A pose with its time, in the frame of the header.
struct PoseStamped {
  static constexpr MessageType kType{"geometry_msgs/PoseStamped",
                                     "d3812c3cbc69362b77dc0b19b345f8f5"};
  Header header;  ///< time, and frame of the pose
  Pose pose;      ///< in that frame
  static void fields(auto& m, auto& a) { a("header", m.header), a("pose", m.pose); }
};

/// Poses of one time, in the frame of the header.
struct PoseArray {
  static constexpr MessageType kType{"geometry_msgs/PoseArray", "916c28c5764443f268b296bb671b9d97"};
  Header header;                 ///< time, and frame of the poses
  std::vector<Pose> poses = {};  ///< in that frame
  static void fields(auto& m, auto& a) { a("header", m.header), a("poses", m.poses); }
};

/// Covariance row by row of x, y, z and rotations about x, y, z.
struct PoseWithCovariance {
  static constexpr MessageType kType{"geometry_msgs/PoseWithCovariance"};
  Pose pose;                               ///< mean
  std::array<double, 36> covariance = {};  ///< m², m·rad, rad²
  static void fields(auto& m, auto& a) { a("pose", m.pose), a("covariance", m.covariance); }
};

/// The same with its covariance.
struct PoseWithCovarianceStamped {
  static constexpr MessageType kType{"geometry_msgs/PoseWithCovarianceStamped",
                                     "953b798c0f514ff060a53a3498ce6246"};
  Header header;            ///< time, and frame of the pose
  PoseWithCovariance pose;  ///< in that frame
  static void fields(auto& m, auto& a) { a("header", m.header), a("pose", m.pose); }
};

/// Velocities, m/s and rad/s.
struct Twist {
  static constexpr MessageType kType{"geometry_msgs/Twist"};
  Vector3 linear,  ///< m/s
      angular;     ///< rad/s
  static void fields(auto& m, auto& a) { a("linear", m.linear), a("angular", m.angular); }
};

/// Velocities with their covariance, as of PoseWithCovariance.
struct TwistWithCovariance {
  static constexpr MessageType kType{"geometry_msgs/TwistWithCovariance"};
  Twist twist;                             ///< mean
  std::array<double, 36> covariance = {};  ///< squares of m/s, rad/s
  static void fields(auto& m, auto& a) { a("twist", m.twist), a("covariance", m.covariance); }
};

/// A rigid transformation.
struct TransformParts {
  static constexpr MessageType kType{"geometry_msgs/Transform"};
  Vector3 translation;  ///< m
  Quaternion rotation;  ///< child to parent
  static void fields(auto& m, auto& a) {
    a("translation", m.translation), a("rotation", m.rotation);
  }
};

/// The pose of `child_frame_id` in `header.frame_id`.
struct TransformStamped {
  static constexpr MessageType kType{"geometry_msgs/TransformStamped"};
  Header header;                    ///< time, and parent frame
  std::string child_frame_id = {};  ///< child frame
  TransformParts transform;         ///< pose of the child in the parent
  static void fields(auto& m, auto& a) {
    a("header", m.header), a("child_frame_id", m.child_frame_id), a("transform", m.transform);
  }
};

/// Transforms of /tf and /tf_static.
struct TfMessage {
  static constexpr MessageType kType{"tf2_msgs/TFMessage", "94810edda583a504dfda3829e70d7eec"};
  std::vector<TransformStamped> transforms = {};  ///< in any order
  static void fields(auto& m, auto& a) { a("transforms", m.transforms); }
};

}  // namespace wayfare::ros
