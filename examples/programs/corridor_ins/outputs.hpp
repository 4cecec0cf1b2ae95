#pragma once

// Files and report of corridor_ins.

#include <optional>
#include <string>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/nav/corridor_ins.hpp>

#include "support/program_files.hpp"

namespace wayfare::examples {

struct CorridorOutputs {
  std::string title;
  const Recording& recording;
  const CorridorRun& run;
  const CorridorRun& unaided;            ///< without walls
  const Trajectory& reference;           ///< in any frame; may be empty
  bool same_frame = false;               ///< reference in the run's frame: no alignment
  std::optional<LocalPlane> plane = {};  ///< for latitude and longitude
  std::vector<double> bias = {};         ///< true gyro bias of each epoch, rad/s; may be empty
  Facts facts = {};
  TitledTables tables = {};
};

[[nodiscard]] Trajectory trajectory_of(const CorridorRun& run);

/// Writes navigation.txt, trajectory.tum, unaided.tum, walls.png and report.html.
[[nodiscard]] Result<void> write_corridor_outputs(const OutputArguments& to,
                                                  const CorridorOutputs& outputs);

}  // namespace wayfare::examples
