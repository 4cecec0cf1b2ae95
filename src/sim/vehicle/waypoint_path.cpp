#include "sim/vehicle/waypoint_path.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include <wayfare/core/angle.hpp>

namespace wayfare::sim {
namespace {

using Eigen::Vector2d;

Vector2d direction(double heading) { return {std::cos(heading), std::sin(heading)}; }

// ∫₀^s of the direction along a unit-length corner with heading change `turn`: its curvature is
// 2 turn sin²(πs), so that it starts and ends at zero with zero slope.
Vector2d unit_corner(double turn, double s) {
  constexpr int kSteps = 64;  // Simpson
  const auto heading = [&](double x) {
    return turn * (x - std::sin(2.0 * std::numbers::pi * x) / (2.0 * std::numbers::pi));
  };
  Vector2d sum = direction(heading(0.0)) + direction(heading(s));
  for (int i = 1; i < kSteps; ++i)
    sum += (i % 2 == 1 ? 4.0 : 2.0) * direction(heading(s * i / kSteps));
  return sum * s / (3.0 * kSteps);
}

// A waypoint with the leg after it and its corner.
struct Corner {
  Vector2d at = Vector2d::Zero();
  double leg_m = 0.0, heading = 0.0;
  double turn = 0.0, length_m = 0.0, tangent_m = 0.0;
};

Result<std::vector<Corner>> corners_of(std::span<const Waypoint> waypoints) {
  std::vector<Corner> corners;
  for (std::size_t i = 0; i < waypoints.size(); ++i) {
    const Waypoint& w = waypoints[i];
    Corner c;
    c.at = {w.north_m, w.east_m};
    if (!c.at.allFinite() || !std::isfinite(w.height_m) || !(w.stop_s >= 0.0))
      return Error{ErrorCode::invalid, "waypoint " + std::to_string(i) + " is not finite"};
    if (std::abs(w.height_m) > 1e6)
      return Error{ErrorCode::invalid,
                   "waypoint " + std::to_string(i) + " is more than 1000 km above or below"};
    if (!corners.empty()) {
      Corner& before = corners.back();
      const Vector2d leg = c.at - before.at;
      before.leg_m = leg.norm();
      if (before.leg_m < 0.1)
        return Error{ErrorCode::invalid,
                     "waypoint " + std::to_string(i) + " is at the position of the previous one"};
      const double heading = std::atan2(leg.y(), leg.x());
      const double last = i > 1 ? corners[i - 2].heading : heading;
      before.turn = wrap_to_pi(heading - last);
      before.heading = last + before.turn;
      if (std::abs(before.turn) > 170.0 / 180.0 * std::numbers::pi)
        return Error{ErrorCode::invalid, "the drive reverses at waypoint " + std::to_string(i - 1)};
    }
    corners.push_back(c);
  }
  if (corners.size() < 2) return Error{ErrorCode::invalid, "a drive needs two waypoints or more"};
  return corners;
}

// As wide as the limits require, as small as the adjacent legs permit.
void round_corners(std::vector<Corner>& corners, double radius_m) {
  for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
    Corner& c = corners[i];
    if (std::abs(c.turn) < 1e-9) {
      c.turn = 0.0;
      continue;
    }
    const double tangent_per_length =
        unit_corner(c.turn, 1.0).norm() / (2.0 * std::cos(0.5 * c.turn));
    const double room = 0.48 * std::min(c.leg_m, corners[i - 1].leg_m);
    c.length_m = std::min(2.0 * std::abs(c.turn) * radius_m, room / tangent_per_length);
    c.tangent_m = c.length_m * tangent_per_length;
  }
}

}  // namespace

PathPoint WaypointPath::at(double along_m) const {
  const PathPiece& p = piece_at(along_m);
  const double x = along_m - p.begin_m;
  if (p.turn == 0.0) return {p.from + x * direction(p.heading), p.heading, 0.0};
  const double s = std::clamp(x / p.length_m, 0.0, 1.0), pi = std::numbers::pi;
  const Vector2d local = p.length_m * unit_corner(p.turn, s);
  const Vector2d ahead = direction(p.heading);
  return {p.from + local.x() * ahead + local.y() * Vector2d(-ahead.y(), ahead.x()),
          p.heading + p.turn * (s - std::sin(2.0 * pi * s) / (2.0 * pi)),
          2.0 * p.turn / p.length_m * std::pow(std::sin(pi * s), 2)};
}

double WaypointPath::height_at(double along_m) const {
  const auto next =
      std::upper_bound(heights_.begin(), heights_.end(), along_m,
                       [](double along, const HeightMark& mark) { return along < mark.along_m; });
  if (next == heights_.begin()) return heights_.front().height_m;
  if (next == heights_.end()) return heights_.back().height_m;
  const HeightMark& a = *(next - 1);
  const double u = (along_m - a.along_m) / (next->along_m - a.along_m);
  return a.height_m + (next->height_m - a.height_m) * u * u * (3.0 - 2.0 * u);
}

const PathPiece& WaypointPath::piece_at(double along_m) const {
  const auto after =
      std::upper_bound(pieces_.begin(), pieces_.end(), along_m,
                       [](double along, const PathPiece& p) { return along < p.begin_m; });
  return after == pieces_.begin() ? pieces_.front() : *(after - 1);
}

Result<WaypointPath> path_through(std::span<const Waypoint> waypoints,
                                  const VehicleLimits& limits) {
  auto corners = corners_of(waypoints);
  if (!corners) return corners.error();
  // The curvature of a corner peaks at twice its mean.
  round_corners(*corners, limits.turn_radius_m);
  WaypointPath path;
  for (std::size_t i = 0; i < corners->size(); ++i) {
    const Corner& c = (*corners)[i];
    if (i > 0) {
      const Corner& before = (*corners)[i - 1];
      const Vector2d ahead = direction(before.heading);
      path.add(before.leg_m - before.tangent_m - c.tangent_m, before.at + before.tangent_m * ahead,
               before.heading, 0.0);
    }
    if (waypoints[i].stop_s > 0.0) path.stop(waypoints[i].stop_s);
    path.mark(waypoints[i].height_m, path.length_so_far() + 0.5 * c.length_m);
    if (c.turn != 0.0 && c.length_m > 0.0)
      path.add(c.length_m, c.at - c.tangent_m * direction((*corners)[i - 1].heading),
               (*corners)[i - 1].heading, c.turn);
  }
  return path;
}

}  // namespace wayfare::sim
