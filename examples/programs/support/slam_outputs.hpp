#pragma once

// Files, report and table of errors of the SLAM programs.

#include <string>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/eval/table.hpp>
#include <wayfare/eval/trajectory_error.hpp>
#include <wayfare/graph/pose_graph.hpp>
#include <wayfare/io/map_image.hpp>
#include <wayfare/map/occupancy_grid.hpp>
#include <wayfare/sensors/recording.hpp>

#include "program_files.hpp"

namespace wayfare::examples {

/// Another estimate of the same run, from the same start.
struct NamedTrajectory {
  std::string name;
  std::string file;  ///< in the folder of the results, TUM text
  Trajectory trajectory;
};

/// A finished run. The references must outlive the calls.
struct SlamOutputs {
  std::string title;             ///< of the report
  const Recording& recording;    ///< its odometry is compared with the result
  const Trajectory& trajectory;  ///< one pose per scan, at the scan's time
  const OccupancyGrid& map;
  /// Edges with `robust` set are drawn as loop closures. Without poses it is neither drawn nor
  /// written.
  const PoseGraph2& graph;
  const Trajectory* reference = nullptr;  ///< in any frame, with times around those of the scans
  Facts facts = {};
  TitledTables tables = {};                  ///< shown after the errors
  const OccupancyGrid* radar_map = nullptr;  ///< if it is not `map`
  std::vector<NamedTrajectory> others = {};  ///< written, and shown beside SLAM's
};

/// Errors of a trajectory against the reference.
struct NamedErrors {
  std::string name;
  eval::AbsoluteError absolute;  ///< after the best rigid alignment
  double final_error_m = 0.0;    ///< at the last pose, both started from the same pose
  double final_percent = 0.0;    ///< the same, of the distance travelled
};

/// Of odometry, if the recording has it, of other estimates and, last, of SLAM; empty without a
/// reference.
[[nodiscard]] std::vector<NamedErrors> trajectory_errors(const SlamOutputs& run);
/// Lengths and ends of SLAM's path and of others.
[[nodiscard]] eval::Table path_table(const SlamOutputs& run);
[[nodiscard]] eval::Table error_table(const std::vector<NamedErrors>& errors);

/// The positions of a trajectory.
[[nodiscard]] std::vector<Eigen::Vector2d> points_of(const Trajectory& trajectory);
/// The map with the robot's path.
[[nodiscard]] io::Image map_picture(const OccupancyGrid& map, const Trajectory& trajectory);

/// As prepare_files, for the files of `write_slam_outputs` and `more`.
[[nodiscard]] Result<void> prepare_folder(const std::string& folder,
                                          const io::WriteOptions& options = {},
                                          const std::vector<std::string>& more = {});

/// Prepares `folder` and writes trajectory.tum, those of `others`, map.pgm, map.yaml, map.png,
/// graph.g2o and report.html; returns the report's path. With `Existing::refuse` nothing is written
/// if one of them exists.
[[nodiscard]] Result<std::string> write_slam_outputs(const std::string& folder,
                                                     const SlamOutputs& run,
                                                     const io::WriteOptions& options = {});

}  // namespace wayfare::examples
