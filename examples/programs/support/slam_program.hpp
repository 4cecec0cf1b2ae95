#pragma once

// Programs on robot logs: arguments, inputs and printed results, which are the same for all
// systems.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/eval/relations.hpp>
#include <wayfare/graph/pose_graph.hpp>
#include <wayfare/map/occupancy_grid.hpp>
#include <wayfare/sensors/recording.hpp>
#include <wayfare/slam/graph_slam.hpp>
#include <wayfare/slam/radar_slam.hpp>

#include "command_line.hpp"
#include "option_fields.hpp"
#include "progress_line.hpp"
#include "ros_topics.hpp"
#include "slam_doubt.hpp"
#include "slam_outputs.hpp"

namespace wayfare::examples {

struct SlamArguments : OutputArguments {
  std::string log;
  int threads = 1;
  std::uint64_t seed = 1;
  ros::TopicNames topics;
  TruthOptions truth;

  /// Of --truth or the recording.
  [[nodiscard]] Result<Truth> read_truth(const Recording& recording) const;
};

void add_threads(CommandLine& app, int& threads);
void add_relations_by_scan(CommandLine& app, bool& by_scan);
void add_seed(CommandLine& app, SlamArguments& arguments, const std::string& text);

/// The file formats of `read_robot_log`, for --help.
inline constexpr const char* kRobotLogs =
    "CARMEN text, plain or gzip, a ROS recording (ROS 2's .mcap, ROS 1's .bag) or a logger's "
    "recording (.mcap)";
/// Without odometry, it is computed from the wheels. Reports skipped lines on standard error.
/// `needs_laser`: CARMEN text without scans is an error. `doubt`: that most lines were skipped.
[[nodiscard]] Result<Recording> read_robot_log(const std::string& path,
                                               const ros::TopicNames& topics = {},
                                               bool needs_laser = true, Doubt* doubt = nullptr);

/// Odometry that never moves, as in the logs of carriers without wheels, is none.
void drop_still_odometry(Recording& recording);

/// None for an empty path. Reports skipped lines on standard error.
[[nodiscard]] Result<std::vector<eval::Relation>> read_relations_or_none(const std::string& path);

/// A system's run and its duration.
template <class Run>
struct Timed {
  Run slam;
  double took_s = 0.0;
};

/// The result of `run`, which is given a callback for its progress, shown on a line.
template <class Run>
[[nodiscard]] auto run_timed(const std::string& label, bool quiet, const Run& run)
    -> Result<Timed<typename decltype(run(std::declval<ProgressLine&>()))::Value>> {
  ProgressLine progress(label, quiet);
  auto slam = run(progress);
  if (!slam) return slam.error();
  return Timed<typename decltype(slam)::Value>{*std::move(slam), progress.finish()};
}

/// Graph SLAM with a progress line.
[[nodiscard]] Result<Timed<GraphSlamRun>> run_with_progress(const Recording& recording,
                                                            GraphSlamOptions options,
                                                            const SlamArguments& arguments);

/// Default number of particles of the Rao-Blackwellised filter with these sensors.
[[nodiscard]] std::size_t particles_of(SlamSensors sensors);

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

/// Files of a system's state, with which it continues after another log.
struct StateFiles {
  std::string from, to;  ///< none if empty

  /// --continue and --save.
  void add_options(CommandLine& app);
  /// Of `from`, if there is one. An error if `to` cannot be written.
  [[nodiscard]] Result<std::vector<std::uint8_t>> read(const io::WriteOptions& options) const;
  /// An error of a system that continues, with the name of `from` where that is at fault.
  [[nodiscard]] Error named(Error error) const;
  /// To `to`, if there is one.
  [[nodiscard]] Result<void> write(const std::vector<std::uint8_t>& state,
                                   const io::WriteOptions& options) const;
};

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
  std::vector<OtherEstimate> others = {};
  std::string doubt = {};  ///< why the result is in doubt
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
/// The same of a trajectory that may be in several pieces, and whether it is in doubt.
template <class Run>
[[nodiscard]] LogRun log_run_of_pieces(Run& slam, Facts facts) {
  const auto& statistics = slam.statistics;
  const Facts pieces = piece_facts(statistics);
  facts.insert(facts.end(), pieces.begin(), pieces.end());
  LogRun result = log_run(slam, std::move(facts), slam.graph);
  result.doubt = piece_doubt(statistics, slam.crossings, statistics.scans);
  return result;
}

struct LogProgram {
  std::string name;                  ///< "graph_slam"
  std::string system;                ///< "graph SLAM", in the report and the tables
  std::string description;           ///< for --help
  std::vector<OptionField> options;  ///< of --config and --print-config
  std::function<Result<LogRun>(const Recording&, const SlamArguments&, const SlamProgress&)> run;
  std::function<Result<void>()> check_options = {};  ///< after --config, beyond the fields' ranges
  std::function<void(CommandLine&)> more_options = {};
  std::vector<std::string> more_files = {};  ///< those of LogRun::others
};

/// The program's main; returns its exit code.
int run_log_program(int argc, char** argv, const LogProgram& program);

}  // namespace wayfare::examples
