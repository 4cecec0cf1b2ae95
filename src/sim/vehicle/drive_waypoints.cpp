// A drive in three steps: a path of straight pieces and corners with continuous curvature, a speed
// profile within the limits, and smooth curves over time through both.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <string>

#include <wayfare/core/angle.hpp>
#include <wayfare/sim/vehicle_trajectory.hpp>

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

/// A straight piece (turn 0) or a corner.
struct PathPiece {
  double begin_m = 0.0;  ///< along the path
  double length_m = 0.0;
  Vector2d from = Vector2d::Zero();
  double heading = 0.0;  ///< at its beginning, not wrapped
  double turn = 0.0;
};

/// A point on the path; curvature is positive to the right, as headings are.
struct PathPoint {
  Vector2d position = Vector2d::Zero();
  double heading = 0.0;
  double curvature = 0.0;
};

struct HeightMark {
  double along_m = 0.0, height_m = 0.0;
};
struct PathStop {
  double along_m = 0.0, duration_s = 0.0;
};

class WaypointPath {
 public:
  [[nodiscard]] double length_m() const { return pieces_.back().begin_m + pieces_.back().length_m; }
  [[nodiscard]] const std::vector<PathPiece>& pieces() const { return pieces_; }
  [[nodiscard]] const std::vector<PathStop>& stops() const { return stops_; }

  void add(double length_m, const Vector2d& from, double heading, double turn) {
    const double begin = pieces_.empty() ? 0.0 : length_m_so_far_;
    pieces_.push_back({begin, length_m, from, heading, turn});
    length_m_so_far_ = begin + length_m;
  }
  void mark(double height_m, double along_m) { heights_.push_back({along_m, height_m}); }
  void stop(double duration_s) { stops_.push_back({length_m_so_far_, duration_s}); }
  [[nodiscard]] double length_so_far() const { return length_m_so_far_; }

  [[nodiscard]] PathPoint at(double along_m) const {
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
  /// Horizontal at every waypoint, cubic between.
  [[nodiscard]] double height_at(double along_m) const {
    const auto next =
        std::upper_bound(heights_.begin(), heights_.end(), along_m,
                         [](double along, const HeightMark& mark) { return along < mark.along_m; });
    if (next == heights_.begin()) return heights_.front().height_m;
    if (next == heights_.end()) return heights_.back().height_m;
    const HeightMark& a = *(next - 1);
    const double u = (along_m - a.along_m) / (next->along_m - a.along_m);
    return a.height_m + (next->height_m - a.height_m) * u * u * (3.0 - 2.0 * u);
  }

 private:
  [[nodiscard]] const PathPiece& piece_at(double along_m) const {
    const auto after =
        std::upper_bound(pieces_.begin(), pieces_.end(), along_m,
                         [](double along, const PathPiece& p) { return along < p.begin_m; });
    return after == pieces_.begin() ? pieces_.front() : *(after - 1);
  }

  std::vector<PathPiece> pieces_;
  std::vector<HeightMark> heights_;
  std::vector<PathStop> stops_;
  double length_m_so_far_ = 0.0;
};

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
    if (!c.at.allFinite() || !std::isfinite(w.height_m) || !std::isfinite(w.stop_s))
      return Error{ErrorCode::invalid, "waypoint " + std::to_string(i) + " is not finite"};
    if (w.stop_s < 0.0)
      return Error{ErrorCode::invalid,
                   "waypoint " + std::to_string(i) + " has a negative time at rest"};
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

/// As widely as the limits require and the adjacent legs permit. Errors: fewer than two waypoints,
/// one that is not finite or at the position of the previous one, a path that reverses.
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
  SpeedProfile(const WaypointPath& path, const VehicleLimits& limits) {
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

  [[nodiscard]] double duration_s() const { return marks_.back().time_s; }
  [[nodiscard]] double along_m(double t) const {
    if (t <= 0.0) return 0.0;
    const auto after = std::upper_bound(marks_.begin(), marks_.end(), t,
                                        [](double time, const Mark& m) { return time < m.time_s; });
    if (after == marks_.end()) return marks_.back().along_m;
    const Mark& a = *(after - 1);
    const double length = after->time_s - a.time_s, u = t - a.time_s;
    const double acceleration = (after->speed_mps - a.speed_mps) / length;
    return a.along_m + (a.speed_mps + 0.5 * acceleration * u) * u;
  }
  /// Mean over the `width` before `t`, s, which makes the acceleration continuous.
  [[nodiscard]] double smooth_along_m(double t, double width) const {
    constexpr int kSteps = 32;
    double sum = 0.5 * (along_m(t) + along_m(t - width));
    for (int i = 1; i < kSteps; ++i) sum += along_m(t - width * i / kSteps);
    return sum / kSteps;
  }

 private:
  struct Mark {
    double time_s, along_m, speed_mps;
  };

  void lay_out(const std::vector<double>& speed, const std::vector<double>& stand, double ds) {
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

  std::vector<Mark> marks_;
};

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

}  // namespace wayfare::sim
