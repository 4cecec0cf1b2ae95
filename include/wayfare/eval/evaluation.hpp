#pragma once

// Trajectories of a run compared with its true poses: a checked reference, the errors started at
// the same pose and after rigid alignment, and their tables.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/eval/table.hpp>
#include <wayfare/eval/trajectory_error.hpp>
#include <wayfare/sensors/trajectory.hpp>

namespace wayfare::eval {

/// True poses of a run, in any frame.
struct Reference {
  Trajectory poses = {};    ///< in order of time
  bool has_heading = true;  ///< else positions alone, such as surveyed points
};

/// Errors: fewer than two poses; a pose that is not finite; times that do not increase (with the
/// number of the pose).
[[nodiscard]] inline Result<void> check(const Reference& reference) {
  const Trajectory& poses = reference.poses;
  const auto error = [&](std::size_t i, const std::string& what) {
    return Error{ErrorCode::invalid, "pose " + std::to_string(i + 1) + ", at " +
                                         fixed(poses[i].time.seconds(), 3) + " s, " + what};
  };
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (!poses[i].T_map_base.raw().log().allFinite()) return error(i, "is not finite");
    if (i == 0 || poses[i - 1].time < poses[i].time) continue;
    return error(i, poses[i].time < poses[i - 1].time ? "is earlier than the pose before it"
                                                      : "has the time of the pose before it");
  }
  if (poses.size() < 2) return Error{ErrorCode::invalid, "has fewer than two poses"};
  return {};
}

/// A gap of the reference, in which it is not interpolated: more than 2.5 s and three times its
/// usual interval.
[[nodiscard]] inline GapLimit gaps_of(std::span<const StampedPose> reference) {
  std::vector<Duration> intervals;
  for (std::size_t i = 1; i < reference.size(); ++i)
    intervals.push_back(reference[i].time - reference[i - 1].time);
  constexpr Duration kLeast = std::chrono::milliseconds(2500);
  const Duration usual = std::min(upper_median_of(intervals), Duration::max() / 3);
  return {std::max(kLeast, 3 * usual), std::chrono::milliseconds(15)};
}

/// Pairs at the times of the trajectory with fewer poses in their common time; the other one is
/// interpolated, the reference not in its gaps. Both in order of time.
[[nodiscard]] inline std::vector<PosePair> common_poses(std::span<const StampedPose> estimate,
                                                        std::span<const StampedPose> reference) {
  if (estimate.empty() || reference.empty()) return {};
  const auto within = [](std::span<const StampedPose> poses, std::span<const StampedPose> other) {
    return std::count_if(poses.begin(), poses.end(), [&](const StampedPose& p) {
      return p.time >= other.front().time && p.time <= other.back().time;
    });
  };
  if (within(reference, estimate) >= within(estimate, reference))
    return associate(estimate, reference, gaps_of(reference));
  std::vector<PosePair> pairs = associate(reference, estimate);
  for (PosePair& pair : pairs) std::swap(pair.estimate, pair.reference);
  return pairs;
}

/// Whether a run with poses at `times`, in order, can be compared with a checked reference. Errors:
/// no overlap, which times so far apart that they are on different clocks are named as; fewer than
/// two common poses.
[[nodiscard]] inline Result<void> check_overlap(const Reference& reference,
                                                std::span<const LogTime> times) {
  Trajectory run;
  for (const LogTime time : times) run.push_back({time, {}});
  if (run.empty() || reference.poses.empty())
    return Error{ErrorCode::not_found, "there is nothing to compare"};
  const auto span_of = [](const Trajectory& t) {
    return fixed(t.front().time.seconds(), 3) + " to " + fixed(t.back().time.seconds(), 3) + " s";
  };
  const std::string spans =
      ": the true poses are from " + span_of(reference.poses) + ", the log from " + span_of(run);
  const double before_s = run.front().time.seconds() - reference.poses.back().time.seconds();
  const double after_s = reference.poses.front().time.seconds() - run.back().time.seconds();
  constexpr double kDay_s = 86400.0;
  if (std::max(before_s, after_s) > kDay_s)
    return Error{ErrorCode::invalid, "is on another time base" + spans};
  if (std::max(before_s, after_s) > 0.0)
    return Error{ErrorCode::not_found, "does not overlap with the log" + spans};
  if (common_poses(run, reference.poses).size() < 2)
    return Error{ErrorCode::not_found, "has fewer than two poses in common with the log" + spans};
  return {};
}

/// Errors of a trajectory against a reference; NaN where they are not known.
struct Evaluation {
  AbsoluteError unaligned;  ///< in the reference's frame already
  AbsoluteError start;      ///< started at the reference's pose; unknown without its heading
  AbsoluteError rigid;      ///< after the best rigid alignment
};

/// Both in order of time. Without two common poses all errors are NaN.
[[nodiscard]] inline Evaluation evaluate(std::span<const StampedPose> estimate,
                                         const Reference& reference) {
  Evaluation result;
  const std::vector<PosePair> pairs = common_poses(estimate, reference.poses);
  if (pairs.size() < 2) return result;
  result.unaligned = absolute_error(pairs, {Alignment::none});
  result.rigid = absolute_error(pairs, {Alignment::rigid});
  if (reference.has_heading) {
    result.start = absolute_error(pairs, {Alignment::start});
    return result;
  }
  for (AbsoluteError* e : {&result.unaligned, &result.rigid})
    e->heading_deg = {}, e->rmse_heading_deg = e->heading_deg.rmse;
  return result;
}

/// A trajectory's name and its errors.
struct Evaluated {
  std::string name;   ///< row name in tables
  Evaluation errors;  ///< as of evaluate()
};

/// Two rows each, started at the same pose (if the reference has headings) and after rigid
/// alignment; `same_frame` adds one without alignment. RMSE along the axes of the reference's
/// frame, of the heading and of the position; the largest error and that at the end; percent of the
/// reference's path.
[[nodiscard]] inline Table error_table(std::span<const Evaluated> all, bool same_frame = false) {
  Table table({{""},
               {"RMSE x", "m"},
               {"y", "m"},
               {"heading", "deg"},
               {"position", "m"},
               {"of path", "%"},
               {"largest", "m"},
               {"end", "m"},
               {"of path", "%"}});
  const auto row = [&](const std::string& name, const AbsoluteError& e) {
    table.add_row({name, fixed(e.rmse_x_m, 3), fixed(e.rmse_y_m, 3), fixed(e.rmse_heading_deg, 2),
                   fixed(e.translation_m.rmse, 3), fixed(e.percent_of_path, 2),
                   fixed(e.translation_m.max, 3), fixed(e.end_m, 3), fixed(e.end_percent, 2)});
  };
  for (const auto& [name, errors] : all) {
    if (same_frame) row(name + ", as it is", errors.unaligned);
    const bool no_heading = errors.start.times.empty() && !errors.rigid.times.empty();
    if (!no_heading) row(name + ", same start", errors.start);
    row(name + ", aligned", errors.rigid);
  }
  return table;
}

/// The rigid alignment of each, which takes its frame to the reference's: translation, then
/// rotation (the pose of its frame in the reference's); how many poses were compared, and the
/// length of the reference between the first and the last of them.
[[nodiscard]] inline Table alignment_table(std::span<const Evaluated> all) {
  Table table(
      {{""}, {"poses compared"}, {"path", "m"}, {"x", "m"}, {"y", "m"}, {"rotation", "deg"}});
  for (const auto& [name, errors] : all) {
    const AbsoluteError& e = errors.rigid;
    table.add_row({name, std::to_string(e.times.size()), fixed(e.path_length_m, 2),
                   fixed(e.alignment.x(), 3), fixed(e.alignment.y(), 3),
                   fixed(e.alignment.heading().degrees(), 3)});
  }
  return table;
}

}  // namespace wayfare::eval
