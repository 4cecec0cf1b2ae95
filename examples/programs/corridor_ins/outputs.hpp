#pragma once

// What corridor_ins leaves behind.

#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/eval/table.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/nav/corridor_ins.hpp>

namespace wayfare::examples {

/// The bias at each epoch of a run, rad/s.
using BiasTruth = std::vector<double>;

struct CorridorOutputs {
  std::string title;
  const Recording& recording;
  const CorridorRun& run;
  const CorridorRun& unaided;            ///< the same without walls
  const Trajectory& reference;           ///< in any frame; empty where there is none
  bool same_frame = false;               ///< the reference starts where the run does: no alignment
  std::optional<LocalPlane> plane = {};  ///< where latitude and longitude are wanted
  BiasTruth bias = {};                   ///< where it is known
  std::vector<std::pair<std::string, std::string>> facts = {};
  std::vector<std::pair<std::string, eval::Table>> tables = {};
};

[[nodiscard]] Trajectory trajectory_of(const CorridorRun& run);

/// Names of the files, to be asked for before the work.
[[nodiscard]] std::vector<std::string> corridor_files();

/// Writes navigation.txt, trajectory.tum, unaided.tum, walls.png and report.html; gives the
/// report's path.
[[nodiscard]] Result<std::string> write_corridor_outputs(const std::string& folder,
                                                         const CorridorOutputs& outputs,
                                                         const io::WriteOptions& write);

}  // namespace wayfare::examples
