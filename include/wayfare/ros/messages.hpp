#pragma once

// ROS messages of sensors, odometry and maps as plain values, usable without ROS; units and frames
// are REP-103's: SI, x forward, y left, z up.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <wayfare/ros/message_parts.hpp>

namespace wayfare::ros {

/// Beam i points along angle_min + i angle_increment and was measured i time_increment after the
/// stamp.
struct LaserScan {
  static constexpr MessageType kType{"sensor_msgs/LaserScan", "90c7ef2dc6895d81024acba2ac42f369"};
  Header header;                        ///< time of the first beam, and frame of the laser
  float angle_min = 0.0F,               ///< of the first beam, rad
      angle_max = 0.0F,                 ///< of the last, rad
      angle_increment = 0.0F;           ///< from beam to beam, rad
  float time_increment = 0.0F,          ///< from beam to beam, s
      scan_time = 0.0F;                 ///< from scan to scan, s
  float range_min = 0.0F,               ///< smallest measurable, m
      range_max = 0.0F;                 ///< largest measurable, m
  std::vector<float> ranges = {};       ///< m, one for each beam
  std::vector<float> intensities = {};  ///< as many as ranges, or empty
  static void fields(auto& m, auto& a) {
    a("header", m.header), a("angle_min", m.angle_min), a("angle_max", m.angle_max);
    a("angle_increment", m.angle_increment), a("time_increment", m.time_increment);
    a("scan_time", m.scan_time), a("range_min", m.range_min), a("range_max", m.range_max);
    a("ranges", m.ranges), a("intensities", m.intensities);
  }
};

/// A channel of a point cloud.
struct PointField {
  static constexpr MessageType kType{
      "sensor_msgs/PointField",
      {},
      "uint8 INT8=1\nuint8 UINT8=2\nuint8 INT16=3\nuint8 UINT16=4\nuint8 INT32=5\n"
      "uint8 UINT32=6\nuint8 FLOAT32=7\nuint8 FLOAT64=8\n"};
  std::string name = {};      ///< such as x, y, z, intensity
  std::uint32_t offset = 0;   ///< bytes from the start of the point
  std::uint8_t datatype = 0;  ///< one of the constants above
  std::uint32_t count = 0;    ///< numbers in the channel
  static void fields(auto& m, auto& a) {
    a("name", m.name), a("offset", m.offset), a("datatype", m.datatype), a("count", m.count);
  }
};

/// Points as bytes, row by row.
struct PointCloud2 {
  static constexpr MessageType kType{"sensor_msgs/PointCloud2", "1158d486dd51d683ce2f1be655c3c181"};
  Header header;                                 ///< time and frame of the points
  std::uint32_t height = 0,                      ///< rows
      width = 0;                                 ///< points of a row
  std::vector<PointField> fields_of_point = {};  ///< `fields` in the definition
  bool is_bigendian = false;                     ///< byte order of `data`
  std::uint32_t point_step = 0,                  ///< bytes of a point
      row_step = 0;                              ///< bytes of a row
  std::vector<std::uint8_t> data = {};           ///< rows of points
  bool is_dense = false;                         ///< all points are finite
  static void fields(auto& m, auto& a) {
    a("header", m.header), a("height", m.height), a("width", m.width);
    a("fields", m.fields_of_point), a("is_bigendian", m.is_bigendian);
    a("point_step", m.point_step), a("row_step", m.row_step), a("data", m.data);
    a("is_dense", m.is_dense);
  }
};

/// A covariance whose first element is -1 marks a quantity that is not measured.
struct Imu {
  static constexpr MessageType kType{"sensor_msgs/Imu", "6a62c6daae103f4ff57a132d6f95cec2"};
  Header header;                                              ///< time, and axes of the unit
  Quaternion orientation;                                     ///< unit to world
  std::array<double, 9> orientation_covariance = {};          ///< rad², row by row
  Vector3 angular_velocity;                                   ///< rad/s
  std::array<double, 9> angular_velocity_covariance = {};     ///< (rad/s)², row by row
  Vector3 linear_acceleration;                                ///< specific force, m/s²
  std::array<double, 9> linear_acceleration_covariance = {};  ///< (m/s²)², row by row
  static void fields(auto& m, auto& a) {
    a("header", m.header), a("orientation", m.orientation);
    a("orientation_covariance", m.orientation_covariance);
    a("angular_velocity", m.angular_velocity);
    a("angular_velocity_covariance", m.angular_velocity_covariance);
    a("linear_acceleration", m.linear_acceleration);
    a("linear_acceleration_covariance", m.linear_acceleration_covariance);
  }
};

/// A magnetic field in the axes of the sensor.
struct MagneticField {
  static constexpr MessageType kType{"sensor_msgs/MagneticField",
                                     "2f3b0b43eed0c9501de0fa3ff89a45aa"};
  Header header;                                         ///< time, and axes of the sensor
  Vector3 magnetic_field;                                ///< tesla; NaN if not measured
  std::array<double, 9> magnetic_field_covariance = {};  ///< T², row by row
  static void fields(auto& m, auto& a) {
    a("header", m.header), a("magnetic_field", m.magnetic_field);
    a("magnetic_field_covariance", m.magnetic_field_covariance);
  }
};

/// State of joints, such as wheels: `position`, `velocity` and `effort` are as long as `name`, or
/// empty.
struct JointState {
  static constexpr MessageType kType{"sensor_msgs/JointState", "3066dcd76a6cfaef579bd0f34173e9fd"};
  Header header;                       ///< time
  std::vector<std::string> name = {};  ///< of the joints
  std::vector<double> position = {},   ///< rad, of a slider m
      velocity = {},                   ///< rad/s, of a slider m/s
      effort = {};                     ///< N m, of a slider N

  static void fields(auto& m, auto& a) {
    a("header", m.header), a("name", m.name), a("position", m.position);
    a("velocity", m.velocity), a("effort", m.effort);
  }
};

/// State of a satellite receiver.
struct NavSatStatus {
  static constexpr MessageType kType{
      "sensor_msgs/NavSatStatus",
      {},
      "int8 STATUS_NO_FIX=-1\nint8 STATUS_FIX=0\nint8 STATUS_SBAS_FIX=1\nint8 STATUS_GBAS_FIX=2\n"
      "uint16 SERVICE_GPS=1\nuint16 SERVICE_GLONASS=2\nuint16 SERVICE_COMPASS=4\n"
      "uint16 SERVICE_GALILEO=8\n"};
  std::int8_t status = 0;     ///< one of STATUS_…
  std::uint16_t service = 0;  ///< sum of SERVICE_…
  static void fields(auto& m, auto& a) { a("status", m.status), a("service", m.service); }
};

/// A position by satellites.
struct NavSatFix {
  static constexpr MessageType kType{
      "sensor_msgs/NavSatFix", "2d3a8cd499b9b4a0249fb98fd05cfa48",
      "uint8 COVARIANCE_TYPE_UNKNOWN=0\nuint8 COVARIANCE_TYPE_APPROXIMATED=1\n"
      "uint8 COVARIANCE_TYPE_DIAGONAL_KNOWN=2\nuint8 COVARIANCE_TYPE_KNOWN=3\n"};
  Header header;                                   ///< time, and frame of the antenna
  NavSatStatus status;                             ///< kind of fix
  double latitude = 0.0,                           ///< degrees north
      longitude = 0.0;                             ///< degrees east
  double altitude = 0.0;                           ///< m above the ellipsoid
  std::array<double, 9> position_covariance = {};  ///< east, north, up; m²
  std::uint8_t position_covariance_type = 0;       ///< one of the constants above
  static void fields(auto& m, auto& a) {
    a("header", m.header), a("status", m.status), a("latitude", m.latitude);
    a("longitude", m.longitude), a("altitude", m.altitude);
    a("position_covariance", m.position_covariance);
    a("position_covariance_type", m.position_covariance_type);
  }
};

/// Pose of `child_frame_id` in `header.frame_id`; the twist is in the child's own axes.
struct Odometry {
  static constexpr MessageType kType{"nav_msgs/Odometry", "cd5e73d190d741a2f92e81eda573aca7"};
  Header header;                    ///< time, and frame of the pose
  std::string child_frame_id = {};  ///< frame of the robot
  PoseWithCovariance pose;          ///< of the robot
  TwistWithCovariance twist;        ///< of the robot
  static void fields(auto& m, auto& a) {
    a("header", m.header), a("child_frame_id", m.child_frame_id);
    a("pose", m.pose), a("twist", m.twist);
  }
};

/// Poses in order of time.
struct Path {
  static constexpr MessageType kType{"nav_msgs/Path", "6227e2b7e9cce15051f669a5e197bbf7"};
  Header header;                        ///< time, and frame of the poses
  std::vector<PoseStamped> poses = {};  ///< each with its own time
  static void fields(auto& m, auto& a) { a("header", m.header), a("poses", m.poses); }
};

/// Geometry of a map.
struct MapMetaData {
  static constexpr MessageType kType{"nav_msgs/MapMetaData"};
  Stamp map_load_time;      ///< time at which the map was made
  float resolution = 0.0F;  ///< m per cell
  std::uint32_t width = 0,  ///< cells along x
      height = 0;           ///< cells along y
  Pose origin;              ///< of the corner of cell (0, 0)
  static void fields(auto& m, auto& a) {
    a("map_load_time", m.map_load_time), a("resolution", m.resolution), a("width", m.width);
    a("height", m.height), a("origin", m.origin);
  }
};

/// Rows of cells from the origin along x; 0 to 100 percent occupied, -1 unknown.
struct OccupancyGrid {
  static constexpr MessageType kType{"nav_msgs/OccupancyGrid", "3381f2d731d4076ec5c71b0759edbe4e"};
  Header header;                       ///< time, and frame of the map
  MapMetaData info;                    ///< geometry
  std::vector<std::int8_t> data = {};  ///< row by row, `width` × `height`
  static void fields(auto& m, auto& a) {
    a("header", m.header), a("info", m.info), a("data", m.data);
  }
};

/// A hypothesis of a particle filter.
struct Particle {
  static constexpr MessageType kType{"nav2_msgs/Particle"};
  Pose pose;            ///< in the frame of the cloud
  double weight = 0.0;  ///< of all, in [0, 1]
  static void fields(auto& m, auto& a) { a("pose", m.pose), a("weight", m.weight); }
};

/// The particles of a localisation, as Navigation2 has them.
struct ParticleCloud {
  static constexpr MessageType kType{"nav2_msgs/ParticleCloud", "715fd9c4dbf7e8cc634d061defa334ed"};
  Header header;                         ///< time, and frame of the poses
  std::vector<Particle> particles = {};  ///< in any order
  static void fields(auto& m, auto& a) { a("header", m.header), a("particles", m.particles); }
};

/// The points of a radar frame as arrays of `width` elements, in the radar's own axes.
struct RadarScan {
  static constexpr MessageType kType{"wayfare_msgs/RadarScan", "feb82c38b1eb345f1337780005e9cec0"};
  Header header;                        ///< time, and frame of the radar
  std::uint32_t width = 0;              ///< number of points
  std::vector<float> x = {},            ///< forward, m
      y = {},                           ///< left, m
      z = {};                           ///< up, m
  std::vector<float> intensities = {};  ///< dB over the noise
  std::vector<float> velocities = {};   ///< m/s along the beam, positive away
  static void fields(auto& m, auto& a) {
    a("header", m.header), a("width", m.width), a("x", m.x), a("y", m.y), a("z", m.z);
    a("intensities", m.intensities), a("velocities", m.velocities);
  }
};

}  // namespace wayfare::ros
