#include "wall_noise.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include <wayfare/eval/table.hpp>
#include <wayfare/match/lines.hpp>

namespace wayfare::examples {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// Walls that turn by more from scan to scan are those of another corridor.
constexpr double kAnother_deg = 45.0;

double wrapped_deg(Angle angle) { return angle.wrapped().degrees(); }

double change(const std::optional<Wall>& now, const std::optional<Wall>& before) {
  return now && before ? now->offset_m - before->offset_m : kUnknown;
}

/// Acquisition gives the direction up to a half turn.
CorridorWalls facing(const CorridorWalls& walls, const CorridorWalls& like) {
  return std::abs(wrapped_deg(walls.direction - like.direction)) > 90.0 ? reversed(walls) : walls;
}

/// The motion of the laser between two times, in its axes at the first.
std::optional<SE2d> laser_motion(const Recording& recording, const Trajectory& truth, LogTime from,
                                 LogTime to) {
  const auto a = pose_at(truth, from), b = pose_at(truth, to);
  if (!a || !b) return std::nullopt;
  const SE2d mount = recording.T_base_laser.raw();
  return (*a * mount).inverse() * (*b * mount);
}

const LaserScan* scan_at(const Recording& recording, LogTime time) {
  const auto scan = std::lower_bound(recording.scans.begin(), recording.scans.end(), time,
                                     [](const LaserScan& s, LogTime t) { return s.time < t; });
  return scan != recording.scans.end() && scan->time == time ? &*scan : nullptr;
}

double rms(const std::vector<WallChange>& changes, double WallChange::*value) {
  double sum = 0.0, count = 0.0;
  for (const WallChange& c : changes) {
    if (!std::isfinite(c.*value)) continue;
    sum += c.*value * c.*value;
    count += 1.0;
  }
  return std::sqrt(sum / count);
}

}  // namespace

std::vector<WallChange> wall_changes(const Recording& recording, const CorridorRun& run,
                                     const Trajectory& truth, const WallOptions& options) {
  WallDetector detector(options);
  std::vector<WallChange> changes;
  const CorridorEpoch* latest = nullptr;
  for (const CorridorEpoch& epoch : run.epochs) {
    if (epoch.update.outcome == WallOutcome::skipped) continue;
    const CorridorEpoch* last = std::exchange(latest, &epoch);
    if (last == nullptr || !last->update.walls || !epoch.update.walls) continue;
    const CorridorWalls &before = *last->update.walls, now = facing(*epoch.update.walls, before);
    const double turned_deg = wrapped_deg(now.direction - before.direction);
    if (std::abs(turned_deg) > kAnother_deg) continue;
    WallChange c{epoch.time,
                 change(now.left, before.left),
                 change(now.right, before.right),
                 turned_deg,
                 kUnknown,
                 kUnknown,
                 kUnknown,
                 wrapped_deg(now.direction),
                 kUnknown};
    if (const auto motion = laser_motion(recording, truth, last->time, epoch.time)) {
      const CorridorWalls expected = moved(before, *motion);
      c.left_error_m = change(now.left, expected.left);
      c.right_error_m = change(now.right, expected.right);
      c.angle_error_deg = wrapped_deg(now.direction - expected.direction);
    }
    if (const LaserScan* scan = scan_at(recording, epoch.time))
      if (const auto found = detector.search(*scan, now.direction))
        c.searched_deg = wrapped_deg(facing(*found, now).direction);
    changes.push_back(c);
  }
  return changes;
}

std::string to_csv(const std::vector<WallChange>& changes) {
  std::string text =
      "time_s,left_change_m,right_change_m,angle_change_deg,left_error_m,right_error_m,"
      "angle_error_deg,fitted_angle_deg,searched_angle_deg\n";
  for (const WallChange& c : changes) {
    text += eval::fixed(c.time.seconds(), 6);
    for (const double v : {c.left_m, c.right_m, c.angle_deg, c.left_error_m, c.right_error_m,
                           c.angle_error_deg, c.fitted_deg, c.searched_deg})
      text += std::isfinite(v) ? ',' + eval::fixed(v, 6) : std::string(",");
    text += '\n';
  }
  return text;
}

Facts facts_of(const std::vector<WallChange>& changes) {
  double sum = 0.0, count = 0.0;
  for (const WallChange& c : changes) {
    if (!std::isfinite(c.searched_deg)) continue;
    const double difference = wrapped_deg(Angle::degrees(c.searched_deg - c.fitted_deg));
    sum += difference * difference;
    count += 1.0;
  }
  Facts facts;
  if (std::isfinite(rms(changes, &WallChange::angle_error_deg)))
    facts = {
        {"noise of range", eval::fixed(rms(changes, &WallChange::left_error_m), 4) + " m left, " +
                               eval::fixed(rms(changes, &WallChange::right_error_m), 4) +
                               " m right, from scan to scan"},
        {"noise of angle",
         eval::fixed(rms(changes, &WallChange::angle_error_deg), 4) + " deg, from scan to scan"}};
  facts.emplace_back("angle by search", eval::fixed(std::sqrt(sum / count), 4) +
                                            " deg RMS from the fit, " + eval::fixed(count, 0) +
                                            " scans");
  return facts;
}

std::vector<io::Plot> plots_of(const std::vector<WallChange>& changes) {
  const auto series = [&](const char* name, double WallChange::*value) {
    io::Series s{name, {}, {}, io::Mark::fine_points};
    for (const WallChange& c : changes) s.add(to_seconds(c.time - changes.front().time), c.*value);
    return s;
  };
  std::vector<io::Plot> plots = {io::time_plot("Change of the walls' distance per scan", "m"),
                                 io::time_plot("Change of the walls' angle per scan", "deg"),
                                 io::time_plot("Error of the change of distance", "m"),
                                 io::time_plot("Error of the change of angle", "deg"),
                                 io::time_plot("Angle of the walls by both methods", "deg")};
  plots[0].series = {series("left", &WallChange::left_m), series("right", &WallChange::right_m)};
  plots[1].series = {series("angle", &WallChange::angle_deg)};
  plots[2].series = {series("left", &WallChange::left_error_m),
                     series("right", &WallChange::right_error_m)};
  plots[3].series = {series("angle", &WallChange::angle_error_deg)};
  plots[4].series = {series("least squares", &WallChange::fitted_deg),
                     series("search by correlation", &WallChange::searched_deg)};
  return plots;
}

}  // namespace wayfare::examples
