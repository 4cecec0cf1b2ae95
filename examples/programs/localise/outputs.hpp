#pragma once

#include <string>
#include <vector>

#include <wayfare/io/map_image.hpp>
#include <wayfare/slam/localisation.hpp>

#include "support/program_files.hpp"
#include "support/truth.hpp"

namespace wayfare::examples {

/// A finished run; poses in the map's frame. The references must outlive it.
struct LocalisationOutputs {
  std::string title;
  const io::GridImage& map;
  const LocalisationRun& run;
  const Truth& truth;  ///< in the map's frame; may be unknown
  Facts facts = {};
  std::string doubt = {};  ///< why the result is in doubt; empty: it is not
};

/// Errors of the converged poses and of all scans; no tables without truth.
[[nodiscard]] TitledTables localisation_errors(const LocalisationOutputs& outputs);

/// Writes trajectory.tum (the converged poses), poses.csv (every scan) and report.html.
[[nodiscard]] Result<void> write_localisation(const OutputArguments& to,
                                              const LocalisationOutputs& outputs);

}  // namespace wayfare::examples
