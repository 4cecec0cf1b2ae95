#pragma once

// Options of a walker with a range finder, of the program and the node.

#include <wayfare/core/result.hpp>
#include <wayfare/slam/pedestrian_slam.hpp>

#include "pedestrian/step_length_options.hpp"
#include "support/command_line.hpp"

namespace wayfare::examples {

struct WalkerOptions {
  StepLengthOptions length;
  double step_m = 0.0;
  bool no_magnetometer = false, no_steps = false, no_feedback = false, no_heading = false;

  void add_options(CommandLine& app);
  /// Errors: of the calibration's file.
  [[nodiscard]] Result<void> apply(PedestrianSlamOptions& options) const;
};

}  // namespace wayfare::examples
