#pragma once

// The true poses of a run, from a file or from its log: option, errors of trajectories, tables and
// drawing, for all programs that follow a log.

#include <span>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/eval/evaluation.hpp>
#include <wayfare/io/map_image.hpp>
#include <wayfare/io/report.hpp>
#include <wayfare/ros/recording.hpp>
#include <wayfare/sensors/recording.hpp>

#include "command_line.hpp"
#include "program_files.hpp"

namespace wayfare::examples {

/// True poses, in any frame; none if unknown.
struct Truth : eval::Reference {
  Truth() = default;
  Truth(Trajectory true_poses, std::string from, bool with_heading = true)
      : source(std::move(from)) {
    poses = std::move(true_poses);
    has_heading = with_heading;
  }

  std::string source;             ///< the file they are from
  std::vector<double> heights_m;  ///< of the poses; none if unknown

  [[nodiscard]] bool known() const { return !poses.empty(); }
};

struct TruthOptions {
  std::string file;  ///< empty: the truth in the log

  /// --truth; `names` may add another.
  void add_options(CommandLine& app, const std::string& names = "--truth");
  /// Of --truth, else `own`, those in the log, checked for a run with poses at `times`. An error in
  /// those of --truth; unusable ones in the log are reported on standard error and left out.
  [[nodiscard]] Result<Truth> read(const std::string& log, Trajectory own,
                                   std::span<const LogTime> times,
                                   const ros::TopicNames& topics) const;
};

/// Of the measurements that give poses, in order: scans and radar frames, else odometry.
[[nodiscard]] std::vector<LogTime> times_of(const Recording& recording);

/// A trajectory to be compared, which must outlive the call.
struct NamedTrajectory {
  std::string name;
  const Trajectory& poses;
};
/// None without truth.
[[nodiscard]] std::vector<eval::Evaluated> compare(const Truth& truth,
                                                   const std::vector<NamedTrajectory>& all);

/// The errors and the alignments; none of nothing. `same_frame`: with the errors in the truth's
/// frame, which is the run's as well.
[[nodiscard]] TitledTables error_tables(const Truth& truth, std::span<const eval::Evaluated> all,
                                        bool same_frame = false);
/// The same as a part of a report.
void add_errors(io::Report& report, const TitledTables& tables);

/// The true path in the frame of a trajectory with these errors, after rigid alignment.
[[nodiscard]] io::Series truth_series(const Truth& truth, const eval::Evaluation& errors);
/// The same on a picture of a map: its poses are dots on a line.
void draw_truth(io::MapPainter& painter, const Truth& truth, const eval::Evaluation& errors);
/// Distances from the truth over the time since its first pose in common, started at the same pose,
/// if its heading is known, and after rigid alignment; none of nothing.
[[nodiscard]] std::vector<io::Plot> distance_plots(const Truth& truth,
                                                   std::span<const eval::Evaluated> all);

}  // namespace wayfare::examples
