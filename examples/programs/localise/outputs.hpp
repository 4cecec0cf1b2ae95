#pragma once

#include <string>
#include <utility>
#include <vector>

#include <wayfare/eval/table.hpp>
#include <wayfare/io/map_image.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/slam/localisation.hpp>

namespace wayfare::examples {

/// A finished localisation; poses in the map's frame. What is referred to must outlive it.
struct LocalisationOutputs {
  std::string title;
  const io::GridImage& map;
  const LocalisationRun& run;
  const Trajectory& truth;  ///< empty where nobody knows
  std::vector<std::pair<std::string, std::string>> facts = {};
};

/// Names of the files below.
[[nodiscard]] std::vector<std::string> localisation_files();

/// Errors of the poses believed and of all, where there is truth; else no rows.
[[nodiscard]] eval::Table localisation_errors(const LocalisationOutputs& outputs);

/// Writes trajectory.tum (the poses believed), poses.csv (every scan) and report.html; gives the
/// report's path.
[[nodiscard]] Result<std::string> write_localisation(const std::string& folder,
                                                     const LocalisationOutputs& outputs,
                                                     const io::WriteOptions& options);

}  // namespace wayfare::examples
