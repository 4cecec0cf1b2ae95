#pragma once

// Inputs and runs of corridor_ins.

#include <optional>
#include <string>
#include <vector>

#include "evaluate.hpp"
#include "support/option_fields.hpp"
#include "support/slam_program.hpp"

namespace wayfare::examples {

struct CorridorArguments : SlamArguments {
  std::string reference, config;
  int simulated = 0, passes = 4;
  double added_bias_deg_s = 0.0;
  std::vector<double> origin;
  bool no_walls_across = false, rest = false;
};

/// A recording with options and truth.
struct Job {
  Recording recording;
  CorridorInsOptions options;
  Trajectory reference;
  std::optional<sim::CorridorDrive> drive;
  double rest_s = 0.0;
};

/// The simulated drive or the log, with the options of --config.
[[nodiscard]] Result<Job> make_job(const CorridorArguments& arguments);
/// All options of --config with their defaults for logs.
[[nodiscard]] std::string corridor_options_text();

struct Runs {
  CorridorRun aided, unaided;
  std::optional<CorridorRun> without_added;  ///< aided, no bias added
};

[[nodiscard]] Result<Runs> run_all(const Job& job, const CorridorArguments& arguments);

}  // namespace wayfare::examples
