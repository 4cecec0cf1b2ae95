#pragma once

// Files and report of corridor_ins.

#include <optional>
#include <string>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/nav/corridor_ins.hpp>

#include "detectors.hpp"
#include "support/program_files.hpp"
#include "support/truth.hpp"
#include "wall_noise.hpp"

namespace wayfare::examples {

struct CorridorOutputs {
  std::string title;
  const Recording& recording;
  const CorridorRun& run;
  const CorridorRun& unaided;            ///< without walls
  const Truth& truth;                    ///< may be unknown
  bool same_frame = false;               ///< truth in the run's frame: no alignment
  std::optional<LocalPlane> plane = {};  ///< for latitude and longitude
  std::vector<double> bias = {};         ///< true gyro bias of each epoch, rad/s; may be empty
  Facts facts = {};
  TitledTables tables = {};
  std::vector<WallChange> walls = {};         ///< walls.csv and its plots, if there are any
  std::string doubt = {};                     ///< why the result is in doubt; empty: it is not
  std::vector<DetectorEpoch> detectors = {};  ///< may be empty: then detectors.txt is not written
};

/// The run's own tables, and errors with and without walls, if the truth is known.
[[nodiscard]] TitledTables tables_of(const CorridorOutputs& outputs);

/// Writes navigation.txt, trajectory.tum, unaided.tum, walls.png and report.html.
[[nodiscard]] Result<void> write_corridor_outputs(const OutputArguments& to,
                                                  const CorridorOutputs& outputs);

}  // namespace wayfare::examples
