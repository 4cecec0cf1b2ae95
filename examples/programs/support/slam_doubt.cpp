#include "slam_doubt.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include <wayfare/eval/table.hpp>
#include <wayfare/sensors/trajectory.hpp>

namespace wayfare::examples {
namespace {

/// Motion since the beginning of a stretch, by the estimate and by odometry.
struct Motions {
  SE2d estimated, odometry;

  [[nodiscard]] double length_m() const {
    return std::max(estimated.translation().norm(), odometry.translation().norm());
  }
  [[nodiscard]] bool contradict() const {
    const double apart_m = (estimated.translation() - odometry.translation()).norm();
    return apart_m > 0.5 * length_m();
  }
};

/// Counts stretches that contradict one another.
struct Contradictions {
  std::size_t stretches = 0, contradicting = 0;

  void add(bool contradict) {
    ++stretches;
    contradicting += contradict ? 1 : 0;
  }
  void report(Doubt& doubt, const std::string& what) const {
    constexpr std::size_t kFewest = 5;
    if (stretches >= kFewest)
      doubt_share(doubt, contradicting, stretches,
                  what + " in which odometry contradicts the estimated path");
  }
};

}  // namespace

void doubt_share(Doubt& doubt, std::size_t count, std::size_t all, const std::string& what,
                 double share) {
  if (static_cast<double>(count) > share * static_cast<double>(all))
    doubt.add(std::to_string(count) + " of " + std::to_string(all) + " " + what);
}

void doubt_odometry(Doubt& doubt, const Recording& recording, const Trajectory& path) {
  constexpr double kStretch_m = 2.0;
  const double turn_rad = Angle::degrees(45.0).radians();
  const Trajectory odometry = as_trajectory(recording.odometry);
  Contradictions lengths, turns;
  struct Poses {
    SE2d estimated, odometry;
  };
  std::optional<Poses> last, stretch;
  double turned[2] = {0.0, 0.0};
  for (const StampedPose& pose : path) {
    const auto T_odom_base = pose_at(odometry, pose.time);
    if (!T_odom_base) continue;
    const Poses now{pose.T_map_base.raw(), *T_odom_base};
    if (!stretch) stretch = now;
    if (last) {
      turned[0] += (last->estimated.inverse() * now.estimated).heading().radians();
      turned[1] += (last->odometry.inverse() * now.odometry).heading().radians();
    }
    last = now;
    if (std::max(std::abs(turned[0]), std::abs(turned[1])) > turn_rad) {
      const double larger = std::max(std::abs(turned[0]), std::abs(turned[1]));
      turns.add(std::abs(turned[0] - turned[1]) > 0.5 * larger);
      turned[0] = turned[1] = 0.0;
    }
    const Motions moved{stretch->estimated.inverse() * now.estimated,
                        stretch->odometry.inverse() * now.odometry};
    if (moved.length_m() < kStretch_m) continue;
    lengths.add(moved.contradict());
    stretch = now;
  }
  lengths.report(doubt, "stretches of 2 m");
  turns.report(doubt, "turns");
}

void doubt_leaps(Doubt& doubt, const Recording& recording) {
  const std::vector<OdometrySample>& odometry = recording.odometry;
  std::size_t leaps = 0;
  for (std::size_t i = 1; i < odometry.size(); ++i) {
    const SE2d& before = odometry[i - 1].T_odom_base.raw();
    const SE2d& after = odometry[i].T_odom_base.raw();
    const double step_s = to_seconds(odometry[i].time - odometry[i - 1].time);
    leaps += (after.translation() - before.translation()).norm() > 1.5 + 3.0 * step_s ? 1 : 0;
  }
  if (leaps > 0)
    doubt.add("odometry leaps at " + std::to_string(leaps) +
              " of its samples: it was set, or the robot was carried");
}

void doubt_path_leaps(Doubt& doubt, const Recording& recording, const Trajectory& path) {
  constexpr std::size_t kFewest = 10;
  if (path.size() < kFewest) return;
  struct Step {
    LogTime from, to;
    double length_m, time_s;
  };
  std::vector<Step> steps;
  std::vector<double> speeds;
  for (std::size_t i = 1; i < path.size(); ++i) {
    const auto at = [&](std::size_t k) { return path[k].T_map_base.raw().translation(); };
    const Step step{path[i - 1].time, path[i].time, (at(i) - at(i - 1)).norm(),
                    to_seconds(path[i].time - path[i - 1].time)};
    steps.push_back(step);
    speeds.push_back(step.length_m / std::max(step.time_s, 1e-3));
  }
  const auto usual = speeds.begin() + static_cast<std::ptrdiff_t>(0.9 * double(speeds.size()));
  std::nth_element(speeds.begin(), usual, speeds.end());
  const Trajectory odometry = as_trajectory(recording.odometry);
  std::size_t leaps = 0;
  double farthest_m = 0.0;
  for (const Step& step : steps) {
    const double most_m = 1.0 + 2.0 * *usual * step.time_s;
    if (step.length_m <= most_m) continue;
    const auto from = pose_at(odometry, step.from), to = pose_at(odometry, step.to);
    if (from && to && (to->translation() - from->translation()).norm() > most_m) continue;
    ++leaps;
    farthest_m = std::max(farthest_m, step.length_m);
  }
  if (leaps > 0)
    doubt.add("the path leaps at " + std::to_string(leaps) + " of its scans, by at most " +
              eval::fixed(farthest_m, 1) +
              " m: scans before were placed wrong, or the robot was carried");
}

void doubt_gaps(Doubt& doubt, const Recording& recording) {
  constexpr double kLeast_s = 4.0, kSteps = 5.0;
  if (!recording.odometry.empty() || recording.scans.size() < 3) return;
  std::vector<double> steps_s;
  for (std::size_t i = 1; i < recording.scans.size(); ++i)
    steps_s.push_back(to_seconds(recording.scans[i].time - recording.scans[i - 1].time));
  const double longest_s = *std::max_element(steps_s.begin(), steps_s.end());
  const auto middle = steps_s.begin() + std::ssize(steps_s) / 2;
  std::nth_element(steps_s.begin(), middle, steps_s.end());
  if (longest_s > std::max(kLeast_s, kSteps * *middle))
    doubt.add("no scan was taken for " + eval::fixed(longest_s, 1) +
              " s, and there is no odometry: the robot may have been elsewhere after it");
}

void doubt_walls(Doubt& doubt, const WallCrossings& crossings, double share, double of_stretch) {
  if (crossings.share > share || crossings.worst_stretch > of_stretch)
    doubt.add(eval::fixed(100.0 * crossings.share, 0) + " % of the rays cross walls, " +
              eval::fixed(100.0 * crossings.worst_stretch, 0) +
              " % on the worst stretch: a part of the map is likely wrong");
}

Facts piece_facts(const PieceStatistics& s) {
  Facts facts;
  if (s.odometry_leaps > 0) facts.emplace_back("odometry leaps", std::to_string(s.odometry_leaps));
  if (s.pieces > 1)
    facts.emplace_back("pieces", std::to_string(s.pieces) + ", joins " + std::to_string(s.joins) +
                                     " accepted, " + std::to_string(s.joins_refused) + " refused");
  if (s.short_apart > 0)
    facts.emplace_back("not placed", std::to_string(s.scans_apart) + " scans of " +
                                         std::to_string(s.short_apart) +
                                         " short pieces: at predicted poses, not in the map");
  return facts;
}

std::string piece_doubt(const PieceStatistics& s, const WallCrossings& crossings,
                        std::size_t scans) {
  constexpr double kMostCrossing = 0.08, kMostOfStretch = 0.16, kMostShort = 0.03;
  if (s.pieces_apart > 0)
    return std::to_string(s.pieces_apart) +
           " pieces of the trajectory were not joined; they are drawn beside the map";
  Doubt walls;
  doubt_walls(walls, crossings, kMostCrossing, kMostOfStretch);
  if (!walls.why.empty()) return walls.why;
  if (static_cast<double>(s.scans_apart) > kMostShort * static_cast<double>(scans))
    return std::to_string(s.scans_apart) + " of " + std::to_string(scans) +
           " scans are in pieces too short to be placed";
  return {};
}

}  // namespace wayfare::examples
