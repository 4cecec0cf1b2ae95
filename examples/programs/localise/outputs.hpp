#pragma once

#include <string>
#include <vector>

#include <wayfare/eval/table.hpp>
#include <wayfare/io/map_image.hpp>
#include <wayfare/slam/localisation.hpp>

#include "support/program_files.hpp"

namespace wayfare::examples {

/// A finished run; poses in the map's frame. The references must outlive it.
struct LocalisationOutputs {
  std::string title;
  const io::GridImage& map;
  const LocalisationRun& run;
  const Trajectory& truth;  ///< empty if unknown
  Facts facts = {};
};

/// Errors of the converged poses and of all; without truth, no rows.
[[nodiscard]] eval::Table localisation_errors(const LocalisationOutputs& outputs);

/// Writes trajectory.tum (the converged poses), poses.csv (every scan) and report.html.
[[nodiscard]] Result<void> write_localisation(const OutputArguments& to,
                                              const LocalisationOutputs& outputs);

}  // namespace wayfare::examples
