// A drive in three steps: a path with continuous curvature, a speed profile within the limits, and
// smooth curves over time through both.

#include <cmath>

#include <wayfare/sim/vehicle_trajectory.hpp>

#include "sim/vehicle/speed_profile.hpp"
#include "sim/vehicle/waypoint_path.hpp"

namespace wayfare::sim {
namespace {

constexpr double kSample_s = 0.1;  // knots of the curves over time

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
  const SpeedProfile profile(*path, limits);
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
