// A drive in three steps: a path with continuous curvature, a speed profile within the limits, and
// smooth curves over time through both.

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <wayfare/sim/vehicle_trajectory.hpp>

#include "sim/vehicle/waypoint_path.hpp"

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

constexpr double kSample_s = 0.1;  // knots of the curves over time

/// Distance along the path over time: constant acceleration between grid points, with stops.
class SpeedProfile {
 public:
  SpeedProfile(const WaypointPath& path, const VehicleLimits& limits);

  [[nodiscard]] double duration_s() const { return marks_.back().time_s; }
  [[nodiscard]] double along_m(double t) const;
  /// Mean over the `width` before `t`, s, which makes the acceleration continuous.
  [[nodiscard]] double smooth_along_m(double t, double width) const;

 private:
  struct Mark {
    double time_s, along_m, speed_mps;
  };

  void lay_out(const std::vector<double>& speed, const std::vector<double>& stand, double ds);

  std::vector<Mark> marks_;
};

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

struct DriveSamples {
  std::vector<CurveSample> position, attitude;
};

DriveSamples sample_drive(const WaypointPath& path, const SpeedProfile& profile,
                          const Geodetic& origin, const VehicleLimits& limits, double end_s) {
  DriveSamples samples;
  const auto count = static_cast<int>(std::lround(end_s / kSample_s));
  const auto along = [&](double t) { return profile.smooth_along_m(t, limits.build_up_s); };
  for (int i = 0; i <= count; ++i) {
    const double t = i * kSample_s, s = along(t);
    const PathPoint p = path.at(s);
    Geodetic place = geodetic_from_ned({p.position.x(), p.position.y(), 0.0}, origin);
    place.height_m = origin.height_m + path.height_at(s);
    const double speed = (along(t + 0.05) - along(t - 0.05)) / 0.1;
    const double grade = (path.height_at(s + 0.5) - path.height_at(s - 0.5)) / 1.0;
    const double roll = -limits.roll_per_lateral * speed * speed * p.curvature;
    samples.position.push_back({t, ned_from_geodetic(place, origin), 1e-4});
    samples.attitude.push_back({t, {roll, std::atan(grade), p.heading}, 1e-5});
  }
  return samples;
}

}  // namespace

Result<VehicleTrajectory> drive_waypoints(const Geodetic& origin,
                                          std::span<const Waypoint> waypoints,
                                          const VehicleLimits& limits, LogTime start) {
  WAYFARE_EXPECTS(limits.speed_mps > 0.0 && limits.acceleration_mps2 > 0.0 &&
                      limits.braking_mps2 > 0.0 && limits.lateral_acceleration_mps2 > 0.0 &&
                      limits.turn_rate_radps > 0.0 && limits.turn_radius_m > 0.0 &&
                      limits.build_up_s > 0.0,
                  "the limits of a vehicle are positive");
  const auto path = path_through(waypoints, limits);
  if (!path) return path.error();
  constexpr double kLongest_m = 2e6, kLongest_s = 4e5;
  if (!(path->length_m() <= kLongest_m))
    return Error{ErrorCode::invalid, "the drive is longer than 2000 km"};
  const SpeedProfile profile(*path, limits);
  if (!(profile.duration_s() <= kLongest_s))
    return Error{ErrorCode::invalid, "the drive takes longer than 111 hours"};
  const double end_s =
      kSample_s * std::ceil((profile.duration_s() + limits.build_up_s) / kSample_s);
  const DriveSamples samples = sample_drive(*path, profile, origin, limits, end_s);
  auto position = SmoothCurve::fit(samples.position, 0.0, end_s, {kSample_s, 1e3});
  if (!position) return position.error();
  auto attitude = SmoothCurve::fit(samples.attitude, 0.0, end_s, {kSample_s, 1e3});
  if (!attitude) return attitude.error();
  return VehicleTrajectory(origin, start, std::move(position).value(), std::move(attitude).value());
}

VehicleTrajectory demo_drive(LogTime start) {
  constexpr Waypoint kRoute[] = {{0, 0, 0, 8},     {550, 0, 3, 0},     {550, 550, 8, 4},
                                 {1100, 550, 12},  {1100, 1100, 2, 0}, {650, 1400, 5, 0},
                                 {50, 1150, 9, 4}, {50, 450, 4, 0},    {-100, 36, -3, 4.6}};
  VehicleLimits limits;
  limits.speed_mps = 23.0;
  const Geodetic origin{Angle::degrees(51.0797), Angle::degrees(-114.1314), 1100.0};
  return drive_waypoints(origin, kRoute, limits, start).value();
}

VehicleTrajectory round_drive(int rounds, LogTime start) {
  WAYFARE_EXPECTS(rounds > 0, "a drive needs a round");
  VehicleLimits gentle;
  gentle.acceleration_mps2 = gentle.braking_mps2 = gentle.lateral_acceleration_mps2 = 0.8;
  gentle.turn_radius_m = 80.0, gentle.build_up_s = 4.0;
  std::vector<Waypoint> route;
  for (int i = 0; i < rounds; ++i) {
    route.push_back({0, 0, 0, 0});
    route.push_back({900, 0, 10, i % 7 == 0 ? 60.0 : 0.0});
    route.push_back({900, 800, 0, 0});
    route.push_back({0, 800, 5, i % 3 == 0 ? 20.0 : 0.0});
  }
  const Geodetic origin{Angle::degrees(51.0), Angle::degrees(-114.0), 1100.0};
  return drive_waypoints(origin, route, gentle, start).value();
}

}  // namespace wayfare::sim
