#pragma once

// The relations metric: Kümmerle, Steder, Dornhege, Ruhnke, Grisetti, Stachniss, Kleiner, "On
// measuring the accuracy of SLAM algorithms", Autonomous Robots 27 (2009). It compares manually
// verified relative poses, so that an early error does not count again in all later poses.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/core/statistics.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/eval/table.hpp>
#include <wayfare/sensors/recording.hpp>
#include <wayfare/sensors/scans.hpp>
#include <wayfare/sensors/trajectory.hpp>

namespace wayfare::eval {

/// The true pose of the robot at `second` relative to that at `first`.
struct Relation {
  LogTime first;        ///< of one scan
  LogTime second;       ///< of the other
  SE2d T_first_second;  ///< true pose of the second in the axes of the first
};

/// Error of one relation: translation and rotation of δ* ⊖ δ.
struct RelationError {
  std::size_t relation = 0;    ///< its index in the list
  double translation_m = 0.0;  ///< length of the error's translation
  double rotation_deg = 0.0;   ///< absolute
};

/// Errors of all relations that could be compared.
struct RelationsResult {
  Summary translation_m;  ///< of the relations used, m
  Summary rotation_deg;   ///< of the relations used, absolute, degrees
  std::size_t used = 0;   ///< number of relations compared
  /// Relations with an end outside the trajectory, or in too large a gap; not used.
  std::size_t outside = 0;
  std::vector<RelationError> errors;  ///< one per relation used, in order
};

/// How poses at the relations' times are found.
struct RelationsOptions {
  /// Relations that start or end in a gap would measure the interpolation rather than the
  /// trajectory. With this limit 2945 of the 2984 relations of a reduced Intel log are used.
  GapLimit gaps = {.largest_gap = from_seconds(2.5), .near = from_seconds(0.015)};
  /// Uses the pose nearest in time instead of interpolating: relations are between scans, and
  /// jittering time stamps affect a scan's time, not its pose.
  bool nearest_pose = false;
};

/// Relations whose times are numbers of scans, from 0 and in seconds, with the times of `scans`:
/// for logs whose time stamps are not those of the relations. Error: a time that is no scan's
/// number.
[[nodiscard]] inline Result<std::vector<Relation>> relations_by_scan(
    std::span<const Relation> relations, std::span<const LaserScan> scans) {
  constexpr std::int64_t kSecond = 1'000'000'000;
  std::vector<Relation> result(relations.begin(), relations.end());
  for (Relation& relation : result) {
    for (LogTime* time : {&relation.first, &relation.second}) {
      const std::int64_t number = time->nanoseconds() / kSecond;
      const bool whole = number * kSecond == time->nanoseconds();
      if (!whole || number < 0 || std::cmp_greater_equal(number, scans.size())) {
        return Error{ErrorCode::invalid, "a relation's time, " +
                                             std::to_string(to_seconds(time->since_epoch())) +
                                             ", is not the number of one of the " +
                                             std::to_string(scans.size()) + " scans, from 0"};
      }
      *time = scans[static_cast<std::size_t>(number)].time;
    }
  }
  return result;
}

namespace detail {

/// pose_at, or the pose nearest in time if there is one.
[[nodiscard]] inline std::optional<SE2d> end_of_relation(std::span<const StampedPose> trajectory,
                                                         LogTime time,
                                                         const RelationsOptions& options) {
  std::optional<SE2d> between = pose_at(trajectory, time, options.gaps);
  if (!between || !options.nearest_pose) return between;
  auto at = std::partition_point(trajectory.begin(), trajectory.end(),
                                 [&](const StampedPose& s) { return s.time < time; });
  if (at != trajectory.begin() && time - (at - 1)->time < at->time - time) --at;
  return at->T_map_base.raw();
}

}  // namespace detail

/// ε(δ) of eq. (4) there, translation and rotation separately as in its section 4: for each
/// relation δ*ᵢⱼ the error (δ*ᵢⱼ)⁻¹ ∘ xᵢ⁻¹ ∘ xⱼ with xᵢ, xⱼ interpolated on SE(2) at the two times.
/// `trajectory` is in order of time.
[[nodiscard]] inline RelationsResult relations_error(std::span<const StampedPose> trajectory,
                                                     std::span<const Relation> relations,
                                                     const RelationsOptions& options = {}) {
  RelationsResult result;
  std::vector<double> translations, rotations;
  for (std::size_t i = 0; i < relations.size(); ++i) {
    const Relation& r = relations[i];
    const std::optional<SE2d> a = detail::end_of_relation(trajectory, r.first, options);
    const std::optional<SE2d> b = detail::end_of_relation(trajectory, r.second, options);
    if (!a || !b) {
      ++result.outside;
      continue;
    }
    const SE2d error = r.T_first_second.inverse() * (a->inverse() * *b);
    result.errors.push_back({i, error.translation().norm(), std::abs(error.heading().degrees())});
    translations.push_back(result.errors.back().translation_m);
    rotations.push_back(result.errors.back().rotation_deg);
  }
  result.used = result.errors.size();
  result.translation_m = summarise(translations);
  result.rotation_deg = summarise(rotations);
  return result;
}

/// Errors of odometry, if the recording has it, and of the system `name`, whose trajectory is
/// interpolated at the relations' times in one row, and taken at the nearest pose in the other.
[[nodiscard]] inline Table relations_table(const std::string& name, const Recording& recording,
                                           const Trajectory& trajectory,
                                           const std::vector<Relation>& relations) {
  Table table({{"relations"}, {"used"}, {"translation", "m"}, {"rotation", "deg"}});
  const auto row = [&](const std::string& who, const Trajectory& estimated, bool nearest = false) {
    const auto e = relations_error(estimated, relations, {.nearest_pose = nearest});
    table.add_row({who, std::to_string(e.used) + " of " + std::to_string(relations.size()),
                   mean_std(e.translation_m.mean, e.translation_m.std, 4),
                   mean_std(e.rotation_deg.mean, e.rotation_deg.std, 3)});
  };
  if (!recording.odometry.empty()) row("odometry", as_trajectory(recording.odometry));
  row(name, trajectory);
  row(name + ", nearest scans", trajectory, true);
  return table;
}

}  // namespace wayfare::eval
