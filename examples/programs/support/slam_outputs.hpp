#pragma once

// What the SLAM programs leave behind: the same files, the same report, the same table of errors.

#include <string>
#include <utility>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/eval/table.hpp>
#include <wayfare/eval/trajectory_error.hpp>
#include <wayfare/graph/pose_graph.hpp>
#include <wayfare/io/image.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/map/occupancy_grid.hpp>
#include <wayfare/sensors/recording.hpp>

namespace wayfare::examples {

/// A table of the report with the line above it.
struct TitledTable {
  std::string title;
  eval::Table table;
};

/// A finished run; everything referred to must outlive the call it is given to.
struct SlamOutputs {
  std::string title;             ///< heads the report
  const Recording& recording;    ///< its odometry is drawn and measured beside the result
  const Trajectory& trajectory;  ///< one pose for every scan, at the scan's time
  const OccupancyGrid& map;
  /// Edges with `robust` set are drawn as loop closures; of no poses: neither drawn nor written.
  const PoseGraph2& graph;
  const Trajectory* reference = nullptr;  ///< in any frame, at any times around the scans'
  std::vector<std::pair<std::string, std::string>> facts = {};  ///< ("scans", "4791") …
  std::vector<TitledTable> tables = {};                         ///< shown after the errors
  const OccupancyGrid* radar_map = nullptr;  ///< where it is another map than `map`
};

/// How far a trajectory is from the reference.
struct NamedErrors {
  std::string name;
  eval::AbsoluteError absolute;  ///< after the rigid alignment that fits best
  double final_error_m = 0.0;    ///< at the last pose, both started from the same pose
  double final_percent = 0.0;    ///< the same, of the distance travelled
};

/// Odometry (where the recording has it) and SLAM against the reference; empty without one.
[[nodiscard]] std::vector<NamedErrors> trajectory_errors(const SlamOutputs& run);
[[nodiscard]] eval::Table error_table(const std::vector<NamedErrors>& errors);

/// The map as a picture for people with the way of the robot over it.
[[nodiscard]] io::Image map_picture(const OccupancyGrid& map, const Trajectory& trajectory);

/// Makes `folder` where needed. With `Existing::refuse` it is an error where one of the files of
/// `write_slam_outputs`, or one of `more`, is in it already: to be asked before the long work.
[[nodiscard]] Result<void> prepare_folder(const std::string& folder,
                                          const io::WriteOptions& options = {},
                                          const std::vector<std::string>& more = {});

/// Prepares `folder` and writes trajectory.tum, map.pgm, map.yaml, map.png, graph.g2o and
/// report.html; gives the report's path. With `Existing::refuse` nothing is written where one of
/// them is there already.
[[nodiscard]] Result<std::string> write_slam_outputs(const std::string& folder,
                                                     const SlamOutputs& run,
                                                     const io::WriteOptions& options = {});

}  // namespace wayfare::examples
