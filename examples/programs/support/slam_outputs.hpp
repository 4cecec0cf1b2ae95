#pragma once

// Files, report and table of errors of the SLAM programs.

#include <string>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/eval/evaluation.hpp>
#include <wayfare/eval/table.hpp>
#include <wayfare/graph/pose_graph.hpp>
#include <wayfare/io/map_image.hpp>
#include <wayfare/map/occupancy_grid.hpp>
#include <wayfare/sensors/recording.hpp>

#include "program_files.hpp"
#include "truth.hpp"

namespace wayfare::examples {

/// Another estimate of the same run, from the same start.
struct OtherEstimate {
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
  const Truth& truth;  ///< may be unknown
  Facts facts = {};
  TitledTables tables = {};                     ///< shown after the errors
  const OccupancyGrid* radar_map = nullptr;     ///< if it is not `map`
  std::vector<OtherEstimate> others = {};       ///< written, and shown beside SLAM's
  std::vector<Trajectory> particle_paths = {};  ///< drawn and written if there are any
  bool draw_scans = false;                      ///< the points of all scans along the path
  std::string doubt = {};                       ///< why the result is in doubt; empty: it is not
};

/// The files of `particle_paths` and of `draw_scans`.
[[nodiscard]] std::vector<std::string> picture_files(bool particle_paths, bool scans);

/// Errors of odometry, if the recording has it, started at the first pose, of other estimates and,
/// last, of SLAM; empty without truth.
[[nodiscard]] std::vector<eval::Evaluated> trajectory_errors(const SlamOutputs& run);
/// Those errors, lengths and ends of the paths, if there are other estimates, and the run's own
/// tables.
[[nodiscard]] TitledTables tables_of(const SlamOutputs& run);

/// The positions of a trajectory.
[[nodiscard]] std::vector<Eigen::Vector2d> points_of(const Trajectory& trajectory);
/// The map with the robot's path.
[[nodiscard]] io::Image map_picture(const OccupancyGrid& map, const Trajectory& trajectory);

/// As prepare_files, for the files of `write_slam_outputs` and `more`.
[[nodiscard]] Result<void> prepare_folder(const std::string& folder,
                                          const io::WriteOptions& options = {},
                                          const std::vector<std::string>& more = {});

/// Prepares `folder` and writes trajectory.tum, those of `others`, picture_files(), map.pgm,
/// map.yaml, map.png, graph.g2o and report.html, and the report as JSON to the file `json`, if
/// named (OutputArguments); returns the report's path. With `Existing::refuse` nothing is written
/// if one of them exists.
[[nodiscard]] Result<std::string> write_slam_outputs(const std::string& folder,
                                                     const SlamOutputs& run,
                                                     const io::WriteOptions& options = {},
                                                     const std::string& json = {});

}  // namespace wayfare::examples
