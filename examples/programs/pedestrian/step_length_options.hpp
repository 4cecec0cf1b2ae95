#pragma once

// Options for the length of a walker's steps, the same in all programs, and its calibration as a
// file.

#include <cstddef>
#include <span>
#include <string>

#include <wayfare/core/result.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/pedestrian/step_detector.hpp>

#include "support/command_line.hpp"

namespace wayfare::examples {

struct StepLengthOptions {
  std::string length = "kim";
  double factor = 0.0;  ///< zero: that of the model
  double height_m = 1.75;
  std::string calibration;  ///< path of a calibration; the other options are then not used

  void add_options(CommandLine& app);
  [[nodiscard]] Result<StepLength> model() const;
};

/// The word of the model for --length, and its factor.
[[nodiscard]] std::string name_of(const StepLength& model);
[[nodiscard]] double factor_of(const StepLength& model);

/// The model with which the steps add up to `length_m`. Errors: the length is not a positive
/// number, or the steps have no length.
[[nodiscard]] Result<StepLength> calibrated_to(const StepLength& model, std::span<const Step> steps,
                                               double length_m);

/// A calibration as JSON (docs/reference/formats.md).
[[nodiscard]] Result<StepLength> read_step_calibration(const std::string& path);
[[nodiscard]] Result<void> write_step_calibration(const std::string& path, const StepLength& model,
                                                  double known_length_m, std::size_t steps,
                                                  const io::WriteOptions& options);

}  // namespace wayfare::examples
