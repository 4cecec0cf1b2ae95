#pragma once

// Trajectories as TUM text: lines `t x y z qx qy qz qw`, metres, unit quaternion, comments with #.
// Times are exact to the nanosecond; other numbers read back to the same bits. Trajectories in the
// plane also as text columns (text_file.hpp).
//
// Relations files of the SLAM benchmark of Kümmerle et al. 2009: lines `t1 t2 x y z roll pitch
// yaw`, the true pose at t2 relative to that at t1.

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <wayfare/core/detail/eigen_alignment.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/eval/relations.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/sensors/trajectory.hpp>

namespace wayfare::io {

/// A time-stamped pose in space.
struct StampedPose3 {
  LogTime time;                                    ///< of the pose
  Transform3<frame::Map, frame::Base> T_map_base;  ///< of the body
};

using Trajectory3 = std::vector<StampedPose3>;  ///< in order of time

/// The poses of a file.
struct TumFile {
  Trajectory3 trajectory;  ///< in the order of the file
  Problems problems;       ///< malformed lines, skipped
};

/// Errors: the file cannot be read, or contains no pose.
[[nodiscard]] Result<TumFile> read_tum(const std::string& path, const ReadOptions& options = {});
/// The same for text in memory; `source` names it in messages.
[[nodiscard]] Result<TumFile> parse_tum(std::string_view text, const std::string& source);

/// The trajectory projected onto the plane: x, y and the heading of the body's x axis.
[[nodiscard]] Trajectory planar(std::span<const StampedPose3> trajectory);

/// The lines of a trajectory in the plane, with z = 0.
[[nodiscard]] std::string format_tum(std::span<const StampedPose> trajectory);
/// The lines of a trajectory in space.
[[nodiscard]] std::string format_tum(std::span<const StampedPose3> trajectory);

/// Errors: the file exists (see WriteOptions), or cannot be written.
[[nodiscard]] inline Result<void> write_tum(const std::string& path,
                                            std::span<const StampedPose> trajectory,
                                            const WriteOptions& options = {}) {
  return write_file(path, format_tum(trajectory), options);
}
/// Errors: the file exists (see WriteOptions), or cannot be written.
[[nodiscard]] inline Result<void> write_tum(const std::string& path,
                                            std::span<const StampedPose3> trajectory,
                                            const WriteOptions& options = {}) {
  return write_file(path, format_tum(trajectory), options);
}

/// A trajectory in the plane.
struct PoseFile {
  Trajectory trajectory;          ///< in the order of the file
  std::vector<double> heights_m;  ///< of the poses; none if the file has no heights
  bool has_heading = false;       ///< else headings are zero
  Problems problems;              ///< malformed lines, skipped
};

/// TUM text, or columns with a time, x, y and, if known, z and `heading` or `yaw`, or qx qy qz qw.
/// Errors: the file cannot be read, a column is missing or has an unknown unit, or no line is
/// usable.
[[nodiscard]] Result<PoseFile> read_poses(const std::string& path, const ColumnFormat& format = {});
/// The same for text in memory; `source` names it in messages.
[[nodiscard]] Result<PoseFile> parse_poses(std::string_view text, const std::string& source,
                                           const ColumnFormat& format = {});

/// The relations of a file.
struct RelationsFile {
  std::vector<eval::Relation> relations;  ///< z, roll and pitch are ignored
  Problems problems;                      ///< malformed lines, skipped
};

/// Errors: the file cannot be read, or contains no relation.
[[nodiscard]] Result<RelationsFile> read_relations(const std::string& path,
                                                   const ReadOptions& options = {});
/// The same for text in memory; `source` names it in messages.
[[nodiscard]] Result<RelationsFile> parse_relations(std::string_view text,
                                                    const std::string& source);

}  // namespace wayfare::io
