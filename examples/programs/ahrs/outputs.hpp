#pragma once

#include <string>

#include <wayfare/core/result.hpp>
#include <wayfare/io/marg_text.hpp>
#include <wayfare/io/text_file.hpp>

#include "run.hpp"

namespace wayfare::examples {

struct AhrsOutputs {
  std::string title;
  const io::MargFile& file;
  const AhrsRun& run;
  double took_s = 0.0;
};

/// What became of each sensor's readings, and what was begun anew; aligned text.
[[nodiscard]] std::string status_text(const AhrsReport& report);
/// Root mean square errors over the moving samples; empty without a reference.
[[nodiscard]] std::string error_text(const AhrsOutputs& outputs);

/// Makes `folder` where needed; an error where what is to be written is there and must stay.
[[nodiscard]] Result<void> prepare_ahrs_folder(const std::string& folder,
                                               const io::WriteOptions& options);
/// Writes attitude.csv and report.html into `folder`; gives the report's path.
[[nodiscard]] Result<std::string> write_ahrs_outputs(const std::string& folder,
                                                     const AhrsOutputs& outputs,
                                                     const io::WriteOptions& options);

}  // namespace wayfare::examples
