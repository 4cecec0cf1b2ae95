#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <wayfare/io/report.hpp>
#include <wayfare/nav/corridor_ins.hpp>

#include "support/slam_program.hpp"

namespace wayfare::examples {

/// The walls of one scan by tracking, with acquisition where it fails, and by curve fitting in
/// moving windows, as in figure 16 of Liu 2015.
struct DetectorEpoch {
  LogTime time;
  std::optional<CorridorWalls> tracked, windows;
  bool acquired = false;
  double tracked_us = 0.0, windows_us = 0.0;  ///< CPU time of this process
};

[[nodiscard]] std::vector<DetectorEpoch> compare_detectors(const Recording& recording,
                                                           const WallOptions& options);

/// Mean times, scans with walls, and the difference of the directions.
void add_detector_facts(const std::vector<DetectorEpoch>& epochs, Facts& facts);
[[nodiscard]] std::string detectors_text(const std::vector<DetectorEpoch>& epochs);
/// Time and direction over the scans.
[[nodiscard]] std::vector<io::Plot> detector_plots(const std::vector<DetectorEpoch>& epochs);

}  // namespace wayfare::examples
