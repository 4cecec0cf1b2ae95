#pragma once

// Conversion between ROS messages and measurements. Stamps and frames of messages are checked here
// only; the resulting measurements are valid.
//
// `time` is given by the caller, who knows which clock applies: `time_of(message.header.stamp)`, or
// the time of receipt.

#include <map>
#include <optional>
#include <string>
#include <string_view>

#include <wayfare/core/frame.hpp>
#include <wayfare/core/gaussian.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/io/map_image.hpp>
#include <wayfare/ros/messages.hpp>
#include <wayfare/sensors/measurements.hpp>
#include <wayfare/sensors/scans.hpp>
#include <wayfare/sensors/trajectory.hpp>

namespace wayfare::ros {

/// Frames and their parents, from transforms; the last one for each frame applies. Frame names are
/// without the leading slash of early ROS 1.
class FrameTree {
 public:
  /// Replaces an earlier transform of the same child.
  void add(const TransformStamped& transform);

  /// Whether no transform was added.
  [[nodiscard]] bool empty() const { return parents_.empty(); }

  /// The pose of `frame` in `base`; between parent and child their transform as received,
  /// unchecked. Errors: the frames are not connected by valid transforms (the known frames are
  /// listed).
  [[nodiscard]] Result<TransformParts> find(std::string_view base, std::string_view frame) const;

 private:
  struct Parent {
    std::string name;
    TransformParts transform;
  };

  std::map<std::string, Parent, std::less<>> parents_;
};

/// Rotates the axes of `frame` to those of `base`; nothing without a valid transform.
[[nodiscard]] std::optional<SO3d> rotation_of(const FrameTree& tree, std::string_view base,
                                              std::string_view frame);

/// Errors: zero, which means "not set"; before 1970 or after 2106; a second or more of nanoseconds.
[[nodiscard]] Result<LogTime> time_of(const Stamp& stamp);
/// `time` must not be before 1970. Exact.
[[nodiscard]] Stamp stamp_of(LogTime time);
/// Stamp and frame name of a message.
[[nodiscard]] Header header_of(LogTime time, std::string_view frame);

/// The frame name of a message, without the leading slash of early ROS 1.
[[nodiscard]] std::string_view frame_of(const Header& header);
/// Errors: no frame in the message, or another one than `wanted`.
[[nodiscard]] Result<void> check_frame(const Header& header, std::string_view wanted);
/// Errors: `time` differs from `now` by more than `tolerance`, as with unsynchronised computers or
/// a recording played without its clock.
[[nodiscard]] Result<void> check_clock(LogTime time, LogTime now, Duration tolerance);

/// A quaternion from which `yaw_of` gives the same bits, if the rotation was made from an angle
/// within ±π; otherwise the last bit may differ.
[[nodiscard]] Quaternion quaternion_of(const SO2d& rotation);
/// The rotation about z. Errors: not a unit quaternion (all zeros if it was not set).
[[nodiscard]] Result<SO2d> yaw_of(const Quaternion& q);
/// With height zero.
[[nodiscard]] Pose pose_of(const SE2d& pose);
/// The pose in the plane, without height, roll and pitch.
[[nodiscard]] Result<SE2d> plane_pose_of(const Pose& pose);
/// The pose in the plane with its covariance, which in the message is about the axes of the frame,
/// here about those of the pose. Errors: an invalid position or orientation; a covariance of x, y
/// and heading that is not finite, symmetric and positive semi-definite.
[[nodiscard]] Result<Gaussian<SE2d>> gaussian_of(const PoseWithCovariance& message);
/// The same as a message; the covariance of what is not in the plane is zero.
[[nodiscard]] PoseWithCovarianceStamped message_of(const Gaussian<SE2d>& pose, LogTime time,
                                                   std::string_view frame);
/// The pose of `child` in `parent`, with height zero.
[[nodiscard]] TransformStamped transform_of(const SE2d& T_parent_child, LogTime time,
                                            std::string_view parent, std::string_view child);

/// A sensor that measures in its own level plane.
struct Sensor {};
/// The mounting of such a sensor, possibly upside down: its bearings then increase clockwise, and
/// the mounting is that of the scan returned by `turned_over`.
struct LevelMounting {
  Transform2<frame::Base, Sensor> T_base_sensor = {};  ///< of the upright sensor
  bool upside_down = false;                            ///< bearings increase clockwise
};
/// Errors: not a unit quaternion; tilted from the level by more than `max_tilt_rad`.
[[nodiscard]] Result<LevelMounting> level_mounting_of(const TransformParts& T_base_sensor,
                                                      double max_tilt_rad = 0.1);
/// Converts the scan of a laser mounted upside down to that of an upright one at the same position.
[[nodiscard]] wayfare::LaserScan turned_over(wayfare::LaserScan scan);
/// The same for a radar.
[[nodiscard]] wayfare::RadarScan turned_over(wayfare::RadarScan scan);

/// The time is the middle of the sweep, if the message has the sweep's duration. A clockwise scan
/// is converted to counter-clockwise. Bearings are single precision in the message: each is
/// replaced by the shortest decimal number of degrees that rounds to it, if there is one of seven
/// decimals. Errors: invalid bearings or limits, more beams than 360°.
[[nodiscard]] Result<wayfare::LaserScan> laser_scan_of(const LaserScan& message, LogTime time);
/// The message of a scan, without durations.
[[nodiscard]] LaserScan message_of(const wayfare::LaserScan& scan, std::string_view frame);

/// Fields x, y and z, and if present a radial speed (`velocity`, `doppler`, `v_doppler_mps`) and a
/// strength in dB (`intensity`, `snr`, `snr_db`), of any type and either byte order; points that
/// are not finite are dropped. Errors: missing fields, or sizes that contradict each other.
[[nodiscard]] Result<wayfare::RadarScan> radar_scan_of(const PointCloud2& message, LogTime time);
/// Errors: arrays whose length is not the message's width.
[[nodiscard]] Result<wayfare::RadarScan> radar_scan_of(const RadarScan& message, LogTime time);
/// The message of a frame of points.
[[nodiscard]] RadarScan message_of(const wayfare::RadarScan& scan, std::string_view frame);
/// The same as five 32-bit floats per point: x, y, z, intensity, velocity.
[[nodiscard]] PointCloud2 cloud_of(const wayfare::RadarScan& scan, std::string_view frame);

/// Errors: turn rate or specific force marked as not measured, or not finite.
[[nodiscard]] Result<ImuSample> imu_of(const Imu& message, LogTime time);
/// rad/s about the unit's axes; specific force may be missing. Errors: as above.
[[nodiscard]] Result<Eigen::Vector3d> turn_rate_of(const Imu& message);
/// Orientation is marked as not measured.
[[nodiscard]] Imu message_of(const ImuSample& sample, std::string_view frame);
/// The same about a level frame's z axis, without specific force.
[[nodiscard]] Imu message_of(const GyroSample& sample, std::string_view frame);
/// For a true or an estimated pose.
[[nodiscard]] PoseStamped message_of(const StampedPose& pose, std::string_view frame);

/// Microtesla; NaN is passed on.
[[nodiscard]] Eigen::Vector3d field_uT_of(const MagneticField& message);
/// The message of a field; NaN is passed on.
[[nodiscard]] MagneticField magnetic_message_of(const Eigen::Vector3d& field_uT, LogTime time,
                                                std::string_view frame);

/// Errors: no fix, not a position on the Earth, variances that are not positive. An unknown
/// covariance becomes the identity; one that is not positive definite is reduced to its variances.
[[nodiscard]] Result<GnssFix> fix_of(const NavSatFix& message, LogTime time);
/// The message of a fix, without its velocity.
[[nodiscard]] NavSatFix message_of(const GnssFix& fix, std::string_view frame);

/// Errors: an invalid position or orientation.
[[nodiscard]] Result<OdometrySample> odometry_of(const Odometry& message, LogTime time);
/// The message of an odometry pose; covariances are zero, not known.
[[nodiscard]] Odometry message_of(const OdometrySample& sample, std::string_view odom_frame,
                                  std::string_view base_frame);

/// Cells in percent as in map_server: unknown where the probability is NaN.
[[nodiscard]] OccupancyGrid message_of(const io::GridImage& map, LogTime time,
                                       std::string_view frame);
/// The map of a message. The side of its cells, single precision in the message, is the shortest
/// decimal number that rounds to it, as in a map's YAML file. Errors: no cells, or a number of them
/// other than the sizes say; cells smaller than a millimetre or larger than ten metres; an
/// occupancy that is neither a percentage nor -1; an invalid origin.
[[nodiscard]] Result<io::GridImage> grid_image_of(const OccupancyGrid& message);

}  // namespace wayfare::ros
