#pragma once

// A program that runs a SLAM system on a recorded log: arguments, files and report are the same for
// all systems.

#include <cstddef>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/graph/pose_graph.hpp>
#include <wayfare/map/occupancy_grid.hpp>
#include <wayfare/sensors/recording.hpp>
#include <wayfare/slam/graph_slam.hpp>

#include "command_line.hpp"
#include "option_fields.hpp"
#include "slam_program.hpp"

namespace wayfare::examples {

/// Result of a system on a log.
struct LogRun {
  Trajectory trajectory;
  OccupancyGrid map;
  PoseGraph2 graph = {};  ///< without poses: neither drawn nor written
  std::size_t scans = 0;
  std::size_t unmatched_scans = 0;
  Facts facts = {};  ///< of this system
  std::size_t refused_scans = 0;
  std::string first_refusal = {};
};

/// From the run of a system of the library.
template <class Run>
[[nodiscard]] LogRun log_run(Run& slam, Facts facts, PoseGraph2 graph = {}) {
  return {std::move(slam.trajectory),
          std::move(slam.map),
          std::move(graph),
          slam.statistics.scans,
          slam.statistics.unmatched_scans,
          std::move(facts),
          slam.refused_scans,
          std::move(slam.first_refusal)};
}

struct LogProgram {
  std::string name;                  ///< "graph_slam"
  std::string system;                ///< "graph SLAM", in the report and the tables
  std::string description;           ///< for --help
  std::vector<OptionField> options;  ///< of --config and --print-config
  std::function<Result<LogRun>(const Recording&, const SlamArguments&, const SlamProgress&)> run;
  std::function<Result<void>()> check_options = {};  ///< after --config, beyond the fields' ranges
  std::function<void(CommandLine&)> more_options = {};
};

/// The program's main; returns its exit code.
int run_log_program(int argc, char** argv, const LogProgram& program);

}  // namespace wayfare::examples
