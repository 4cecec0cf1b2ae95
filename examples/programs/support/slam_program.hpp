#pragma once

// What the SLAM programs are asked, how they run and what they print.

#include <cstdint>
#include <string>

#include <wayfare/core/result.hpp>
#include <wayfare/slam/graph_slam.hpp>

#include "command_line.hpp"
#include "ros_topics.hpp"
#include "slam_outputs.hpp"

namespace wayfare::examples {

struct SlamArguments {
  std::string log;
  std::string out;  ///< folder of the results
  int threads = 1;
  std::uint64_t seed = 1;
  bool force = false;
  bool quiet = false;
  ros::TopicNames topics;

  [[nodiscard]] io::WriteOptions write() const {
    return {force ? io::Existing::replace : io::Existing::refuse};
  }
};

void add_out(CommandLine& app, SlamArguments& arguments, const std::string& text);
void add_threads(CommandLine& app, SlamArguments& arguments);
void add_seed(CommandLine& app, SlamArguments& arguments, const std::string& text);
/// --force and --quiet.
void add_manners(CommandLine& app, SlamArguments& arguments);

/// What `read_robot_log` takes, for --help.
inline constexpr const char* kRobotLogs =
    "CARMEN text, plain or gzip, a ROS recording (ROS 2's .mcap, ROS 1's .bag) or a logger's "
    "recording (.mcap)";
/// The robot's run in a file of these kinds; says on standard error what had to be skipped.
[[nodiscard]] Result<Recording> read_robot_log(const std::string& path,
                                               const ros::TopicNames& topics = {});

struct TimedRun {
  GraphSlamRun slam;
  double took_s = 0.0;
};

/// Graph SLAM with a line of progress.
[[nodiscard]] Result<TimedRun> run_with_progress(const Recording& recording,
                                                 GraphSlamOptions options,
                                                 const SlamArguments& arguments);

/// "12.3 s, 45 times real time", for a recording of so many seconds.
[[nodiscard]] std::string speed(double took_s, double lasts_s, int decimals);
/// "120 nodes, 150 edges".
[[nodiscard]] std::string size_of(const PoseGraph2& graph);

/// Prints the facts of a run, a line each.
void print_facts(const SlamOutputs& outputs);

/// Prints the facts, the tables and where the report is.
void print_report(const SlamOutputs& outputs, const std::string& report);

}  // namespace wayfare::examples
