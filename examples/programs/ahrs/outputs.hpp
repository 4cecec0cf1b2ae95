#pragma once

#include <string>

#include <wayfare/core/result.hpp>
#include <wayfare/io/marg_text.hpp>

#include "run.hpp"
#include "support/program_files.hpp"

namespace wayfare::examples {

struct AhrsOutputs {
  std::string title;
  const io::MargFile& file;
  const AhrsRun& run;
  double took_s = 0.0;
};

/// Numbers of readings used, missing and refused, by sensor.
[[nodiscard]] std::string status_text(const AhrsReport& report);
/// Root mean square errors over the moving samples; empty without a reference.
[[nodiscard]] std::string error_text(const AhrsOutputs& outputs);

[[nodiscard]] std::vector<std::string> ahrs_output_names();
[[nodiscard]] Result<void> write_ahrs_outputs(const OutputArguments& to,
                                              const AhrsOutputs& outputs);

}  // namespace wayfare::examples
