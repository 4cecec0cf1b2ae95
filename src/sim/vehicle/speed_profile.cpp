#include "sim/vehicle/speed_profile.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace wayfare::sim {
namespace {

constexpr double kPathStep_m = 0.25;

double corner_speed(const PathPiece& corner, const VehicleLimits& limits) {
  const double sharpest = 2.0 * std::abs(corner.turn) / corner.length_m;
  return std::min({limits.speed_mps, std::sqrt(limits.lateral_acceleration_mps2 / sharpest),
                   limits.turn_rate_radps / sharpest});
}

double faster(double v, double acceleration, double ds) {
  return std::sqrt(v * v + 2.0 * acceleration * ds);
}

// A corner's speed extends a little before and after it, since smoothing shifts the profile.
void limit_corners(const WaypointPath& path, const VehicleLimits& limits, double ds,
                   std::vector<double>& speed) {
  for (const PathPiece& piece : path.pieces()) {
    if (piece.turn == 0.0) continue;
    const double v = corner_speed(piece, limits), margin = v * limits.build_up_s;
    const auto first = std::max(0.0, std::ceil((piece.begin_m - margin) / ds));
    const auto last = std::floor((piece.begin_m + piece.length_m + margin) / ds);
    for (auto i = static_cast<std::size_t>(first); i <= static_cast<std::size_t>(last); ++i)
      if (i < speed.size()) speed[i] = std::min(speed[i], v);
  }
}

}  // namespace

SpeedProfile::SpeedProfile(const WaypointPath& path, const VehicleLimits& limits) {
  const auto steps = static_cast<std::size_t>(std::ceil(path.length_m() / kPathStep_m));
  const double ds = path.length_m() / static_cast<double>(steps);
  std::vector<double> speed(steps + 1, limits.speed_mps), stand(steps + 1, 0.0);
  limit_corners(path, limits, ds, speed);
  speed.front() = speed.back() = 0.0;
  for (const PathStop& stop : path.stops()) {
    const auto i = std::min(steps, static_cast<std::size_t>(std::lround(stop.along_m / ds)));
    speed[i] = 0.0;
    stand[i] += stop.duration_s;
  }
  for (std::size_t i = 1; i <= steps; ++i)
    speed[i] = std::min(speed[i], faster(speed[i - 1], limits.acceleration_mps2, ds));
  for (std::size_t i = steps; i-- > 0;)
    speed[i] = std::min(speed[i], faster(speed[i + 1], limits.braking_mps2, ds));
  lay_out(speed, stand, ds);
}

double SpeedProfile::along_m(double t) const {
  if (t <= 0.0) return 0.0;
  const auto after = std::upper_bound(marks_.begin(), marks_.end(), t,
                                      [](double time, const Mark& m) { return time < m.time_s; });
  if (after == marks_.end()) return marks_.back().along_m;
  const Mark& a = *(after - 1);
  const double length = after->time_s - a.time_s, u = t - a.time_s;
  const double acceleration = (after->speed_mps - a.speed_mps) / length;
  return a.along_m + (a.speed_mps + 0.5 * acceleration * u) * u;
}

double SpeedProfile::smooth_along_m(double t, double width) const {
  constexpr int kSteps = 32;
  double sum = 0.5 * (along_m(t) + along_m(t - width));
  for (int i = 1; i < kSteps; ++i) sum += along_m(t - width * i / kSteps);
  return sum / kSteps;
}

void SpeedProfile::lay_out(const std::vector<double>& speed, const std::vector<double>& stand,
                           double ds) {
  double t = 0.0;
  for (std::size_t i = 0; i < speed.size(); ++i) {
    const double s = static_cast<double>(i) * ds;
    if (i > 0) t += 2.0 * ds / (speed[i] + speed[i - 1]);
    marks_.push_back({t, s, speed[i]});
    if (stand[i] == 0.0) continue;
    t += stand[i];
    marks_.push_back({t, s, 0.0});
  }
}

}  // namespace wayfare::sim
