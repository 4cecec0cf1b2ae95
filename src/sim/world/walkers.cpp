#include <wayfare/sim/walkers.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace wayfare::sim {
namespace {

using Eigen::Vector2d;

constexpr double kLeg_m = 0.06, kHalfStance_m = 0.09;

/// Metres along the unit vector to a circle; infinity if it is missed.
double distance_to(const Vector2d& centre, double radius_m, const Vector2d& from,
                   const Vector2d& direction) {
  constexpr double kMissed = std::numeric_limits<double>::infinity();
  const Vector2d to = centre - from;
  const double along = to.dot(direction);
  const double square = radius_m * radius_m - (to.squaredNorm() - along * along);
  if (!(square >= 0.0)) return kMissed;
  const double distance = along - std::sqrt(square);
  return distance > 0.0 ? distance : kMissed;
}

}  // namespace

WalkerParts walker_at(const Walker& walker, LogTime time) {
  const Vector2d path = walker.to_m - walker.from_m;
  const double length_m = path.norm();
  if (!(length_m > 1e-6)) {
    const WalkerPart still{walker.from_m, Vector2d::Zero()};
    return {still, still, still};
  }
  const double walked_m = walker.start_m + walker.speed_m_s * time.seconds();
  const double lap_m = walked_m - 2.0 * length_m * std::floor(walked_m / (2.0 * length_m));
  const bool back = lap_m > length_m;
  const Vector2d along = (back ? -1.0 : 1.0) * path / length_m;
  const Vector2d left = kHalfStance_m * Vector2d(-along.y(), along.x());
  const Vector2d at = walker.from_m + (back ? 2.0 * length_m - lap_m : lap_m) * path / length_m;
  const Vector2d velocity = walker.speed_m_s * along;
  // The legs swing about the body; at the middle of its stance a leg is at rest.
  const double phase = std::numbers::pi * walked_m / walker.stride_m;
  const double swing_m = walker.stride_m / std::numbers::pi * std::sin(phase);
  const double faster = std::cos(phase);
  return {{at, velocity},
          {at + left + swing_m * along, (1.0 + faster) * velocity},
          {at - left - swing_m * along, (1.0 - faster) * velocity}};
}

std::vector<Reflector> reflectors_of(std::span<const Walker> walkers, LogTime time) {
  constexpr double kLegLoss_db = 6.0;
  std::vector<Reflector> reflectors;
  for (const Walker& walker : walkers) {
    const WalkerParts parts = walker_at(walker, time);
    const auto add = [&](const WalkerPart& part, double strength_db) {
      Reflector reflector;
      reflector.at_m = part.at_m;
      reflector.strength_db = strength_db;
      reflector.velocity_m_s = part.velocity_m_s;
      reflectors.push_back(reflector);
    };
    add(parts.body, walker.strength_db);
    add(parts.left, walker.strength_db - kLegLoss_db);
    add(parts.right, walker.strength_db - kLegLoss_db);
  }
  return reflectors;
}

void overlay_walkers(LaserScan& scan, std::span<const Walker> walkers, const SE2d& T_plan_laser,
                     const Lidar2dParams& params, Rng& rng) {
  for (const Walker& walker : walkers) {
    const WalkerParts parts = walker_at(walker, scan.time);
    for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
      const double bearing = scan.bearing(i).radians();
      const Vector2d beam =
          T_plan_laser.rotation() * Vector2d(std::cos(bearing), std::sin(bearing));
      double range_m = std::numeric_limits<double>::infinity();
      for (const WalkerPart& leg : {parts.left, parts.right})
        range_m =
            std::min(range_m, distance_to(leg.at_m, kLeg_m, T_plan_laser.translation(), beam));
      if (!(range_m < params.max_range_m) || range_m < params.min_range_m) continue;
      const double measured_m = range_m + params.range_noise_m * rng.normal();
      if (measured_m < static_cast<double>(scan.ranges_m[i]))
        scan.ranges_m[i] = static_cast<float>(measured_m);
    }
  }
}

std::vector<Walker> walkers_along(std::span<const Vector2d> route_m, std::size_t count, Rng rng) {
  constexpr double kShortest_m = 4.0, kNearest_m = 0.55, kFarthest_m = 0.75;
  double total_m = 0.0;
  const auto length_m = [&](std::size_t i) {
    const double leg_m = (route_m[i] - route_m[i - 1]).norm();
    return leg_m > kShortest_m ? leg_m : 0.0;
  };
  for (std::size_t i = 1; i < route_m.size(); ++i) total_m += length_m(i);
  std::vector<Walker> walkers;
  for (std::size_t k = 0; k < count && total_m > 0.0; ++k) {
    double at_m = rng.uniform() * total_m;
    std::size_t leg = 1;
    while (leg + 1 < route_m.size() && at_m >= length_m(leg)) at_m -= length_m(leg++);
    const Vector2d along = (route_m[leg] - route_m[leg - 1]).normalized();
    const double side = rng.uniform() < 0.5 ? -1.0 : 1.0;
    const Vector2d beside =
        side * rng.uniform(kNearest_m, kFarthest_m) * Vector2d(-along.y(), along.x());
    Walker walker;
    walker.from_m = route_m[leg - 1] + along + beside;
    walker.to_m = route_m[leg] - along + beside;
    walker.speed_m_s = rng.uniform(0.5, 1.4);
    walker.start_m = rng.uniform(0.0, 2.0 * length_m(leg));
    walkers.push_back(walker);
  }
  return walkers;
}

}  // namespace wayfare::sim
