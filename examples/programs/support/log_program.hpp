#pragma once

// A program that follows a robot over a recorded log by one of the SLAM systems: the same
// arguments, the same files and the same report for each of them.

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

/// What a system made of a log.
struct LogRun {
  Trajectory trajectory;
  OccupancyGrid map;
  PoseGraph2 graph = {};  ///< of no poses: neither drawn nor written
  std::size_t scans = 0;
  std::size_t unmatched_scans = 0;
  std::vector<std::pair<std::string, std::string>> facts = {};  ///< what the system counts besides
  std::size_t refused_scans = 0;
  std::string first_refusal = {};
};

struct LogProgram {
  std::string name;                  ///< "graph_slam"
  std::string system;                ///< "graph SLAM", in the report and the tables
  std::string description;           ///< heads --help
  std::vector<OptionField> options;  ///< what --config sets and --print-config prints
  std::function<Result<LogRun>(const Recording&, const SlamArguments&, const SlamProgress&)> run;
  std::function<Result<void>()> check_options =
      {};  ///< after --config, where fields are not enough
  std::function<void(CommandLine&)> more_options = {};
};

/// The program's main: its exit code.
int run_log_program(int argc, char** argv, const LogProgram& program);

}  // namespace wayfare::examples
