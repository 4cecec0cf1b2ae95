#pragma once

// Arguments, inputs and printed results of the programs on robot logs.

#include <cstdint>
#include <string>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/eval/relations.hpp>
#include <wayfare/slam/graph_slam.hpp>

#include "command_line.hpp"
#include "ros_topics.hpp"
#include "slam_outputs.hpp"

namespace wayfare::examples {

struct SlamArguments : OutputArguments {
  std::string log;
  int threads = 1;
  std::uint64_t seed = 1;
  ros::TopicNames topics;
};

void add_threads(CommandLine& app, int& threads);
void add_seed(CommandLine& app, SlamArguments& arguments, const std::string& text);

/// The file formats of `read_robot_log`, for --help.
inline constexpr const char* kRobotLogs =
    "CARMEN text, plain or gzip, a ROS recording (ROS 2's .mcap, ROS 1's .bag) or a logger's "
    "recording (.mcap)";
/// Reports skipped lines on standard error.
[[nodiscard]] Result<Recording> read_robot_log(const std::string& path,
                                               const ros::TopicNames& topics = {});

/// None for an empty path. Reports skipped lines on standard error.
[[nodiscard]] Result<std::vector<eval::Relation>> read_relations_or_none(const std::string& path);

/// A system's run and its duration.
template <class Run>
struct Timed {
  Run slam;
  double took_s = 0.0;
};

/// Graph SLAM with a progress line.
[[nodiscard]] Result<Timed<GraphSlamRun>> run_with_progress(const Recording& recording,
                                                            GraphSlamOptions options,
                                                            const SlamArguments& arguments);

/// "12.3 s, 45 times real time".
[[nodiscard]] std::string speed(double took_s, double recording_s, int decimals);
/// "120 nodes, 150 edges".
[[nodiscard]] std::string size_of(const PoseGraph2& graph);
/// "3 accepted, 1 refused".
[[nodiscard]] std::string accepted_and_refused(std::size_t accepted, std::size_t refused);
/// On standard error, if there are any.
void print_refused_scans(std::size_t count, const std::string& first);

/// Prints facts, tables and the path of the report.
void print_report(const SlamOutputs& outputs, const std::string& report);

}  // namespace wayfare::examples
