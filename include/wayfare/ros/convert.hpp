#pragma once

// Between ROS messages and measurements. What a message says of its stamp and frame is checked
// here and nowhere else; a measurement that comes out is one the systems can take.
//
// `time` is given by the caller, who knows whose clock counts: `time_of(message.header.stamp)`, or
// when the message was received.

#include <optional>
#include <string>
#include <string_view>

#include <wayfare/core/frame.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/io/map_image.hpp>
#include <wayfare/ros/messages.hpp>
#include <wayfare/sensors/gnss.hpp>
#include <wayfare/sensors/imu.hpp>
#include <wayfare/sensors/laser_scan.hpp>
#include <wayfare/sensors/radar_scan.hpp>
#include <wayfare/sensors/trajectory.hpp>
#include <wayfare/sensors/wheels.hpp>

namespace wayfare::ros {

/// Errors: zero, which is "not set"; before 1970; a second or more of nanoseconds.
[[nodiscard]] Result<LogTime> time_of(const Stamp& stamp);
/// `time` must not lie before 1970. Exact.
[[nodiscard]] Stamp stamp_of(LogTime time);
[[nodiscard]] Header header_of(LogTime time, std::string_view frame);

/// The frame a message names, without the slash ROS 1 once put before it.
[[nodiscard]] std::string_view frame_of(const Header& header);
/// Errors: the message names no frame, or another one than `wanted`.
[[nodiscard]] Result<void> check_frame(const Header& header, std::string_view wanted);
/// Errors: `time` lies further than `tolerance` from `now`, as it does where two computers' clocks
/// disagree or a recording is played without its clock.
[[nodiscard]] Result<void> check_clock(LogTime time, LogTime now, Duration tolerance);

/// The quaternion from which `yaw_of` gives the same bits, where the rotation was made of an angle
/// within half a turn; of another one the last bit may differ.
[[nodiscard]] Quaternion quaternion_of(const SO2d& rotation);
/// The rotation about z; errors: not a unit quaternion (all zeros where nobody set it).
[[nodiscard]] Result<SO2d> yaw_of(const Quaternion& q);
[[nodiscard]] Pose pose_of(const SE2d& pose);
/// The pose in the plane, its height, roll and pitch left out.
[[nodiscard]] Result<SE2d> plane_pose_of(const Pose& pose);
[[nodiscard]] TransformStamped transform_of(const SE2d& T_parent_child, LogTime time,
                                            std::string_view parent, std::string_view child);

/// A sensor that measures in its own level plane.
struct Sensor {};
/// How such a sensor sits on the robot, upside down perhaps: its bearings count clockwise then, and
/// the mounting is that of the scan `turned_over` gives.
struct LevelMounting {
  Transform2<frame::Base, Sensor> T_base_sensor = {};
  bool upside_down = false;
};
/// Errors: no unit quaternion; tilted by more than `most_tilt_rad` off the level.
[[nodiscard]] Result<LevelMounting> level_mounting_of(const TransformParts& T_base_sensor,
                                                      double most_tilt_rad = 0.1);
/// The scan of a laser upside down as one of a laser upright in the same place.
[[nodiscard]] wayfare::LaserScan turned_over(wayfare::LaserScan scan);

/// The time is the middle of the sweep, where the message says how long one takes. A scan that goes
/// clockwise is given counter-clockwise. Bearings are single precision on the wire: each stands for
/// the shortest decimal number of degrees that rounds to it, where one of seven decimals does.
/// Errors: bearings or limits that are none, more beams than a turn.
[[nodiscard]] Result<wayfare::LaserScan> laser_scan_of(const LaserScan& message, LogTime time);
[[nodiscard]] LaserScan message_of(const wayfare::LaserScan& scan, std::string_view frame);

/// Fields x, y and z, and where they are there a radial speed (`velocity`, `doppler`,
/// `v_doppler_mps`) and a strength in dB (`intensity`, `snr`, `snr_db`), of any type and either
/// byte order; points that are not finite are left out. Errors: no such fields, or sizes that
/// contradict each other.
[[nodiscard]] Result<wayfare::RadarScan> radar_scan_of(const PointCloud2& message, LogTime time);
/// Errors: arrays of another length than the message's width.
[[nodiscard]] Result<wayfare::RadarScan> radar_scan_of(const RadarScan& message, LogTime time);
[[nodiscard]] RadarScan message_of(const wayfare::RadarScan& scan, std::string_view frame);
/// The same as five 32-bit floats a point: x, y, z, intensity, velocity.
[[nodiscard]] PointCloud2 cloud_of(const wayfare::RadarScan& scan, std::string_view frame);

/// Errors: a unit that says it does not measure turn rate or specific force, or gives no number.
[[nodiscard]] Result<ImuSample> imu_of(const Imu& message, LogTime time);
/// rad/s about the unit's axes, of one that may measure nothing else. Errors: as above.
[[nodiscard]] Result<Eigen::Vector3d> turn_rate_of(const Imu& message);
/// The orientation is marked as not measured.
[[nodiscard]] Imu message_of(const ImuSample& sample, std::string_view frame);
/// The same about a level frame's z axis; of specific force nothing is measured.
[[nodiscard]] Imu message_of(const GyroSample& sample, std::string_view frame);
/// Of a true or an estimated pose.
[[nodiscard]] PoseStamped message_of(const StampedPose& pose, std::string_view frame);

/// Microtesla; NaN where the message has it.
[[nodiscard]] Eigen::Vector3d field_uT_of(const MagneticField& message);
[[nodiscard]] MagneticField magnetic_message_of(const Eigen::Vector3d& field_uT, LogTime time,
                                                std::string_view frame);

/// Errors: no fix, or no place on the Earth. A covariance that is not known is the identity.
[[nodiscard]] Result<GnssFix> fix_of(const NavSatFix& message, LogTime time);
[[nodiscard]] NavSatFix message_of(const GnssFix& fix, std::string_view frame);

/// Errors: a position or orientation that is none.
[[nodiscard]] Result<OdometrySample> odometry_of(const Odometry& message, LogTime time);
[[nodiscard]] Odometry message_of(const OdometrySample& sample, std::string_view odom_frame,
                                  std::string_view base_frame);

/// Cells in percent as map_server has them: unknown where the probability is NaN.
[[nodiscard]] OccupancyGrid message_of(const io::GridImage& map, LogTime time,
                                       std::string_view frame);

}  // namespace wayfare::ros
