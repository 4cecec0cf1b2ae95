#include <wayfare/sim/radar.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/robot/radar_cube.hpp"
#include "sim/robot/radar_detector.hpp"

namespace wayfare::sim {
namespace {

using Eigen::Vector2d;

constexpr double kPi = std::numbers::pi;

// Number of walls between two points, up to one more than `at_most`.
int walls_between(const FloorPlan& plan, const Vector2d& from, const Vector2d& to, int at_most) {
  constexpr double kOwnWall_m = 0.03;  // the wall of a reflector does not hide it
  const Vector2d line = to - from;
  double left = line.norm() - kOwnWall_m;
  if (left <= 0.0) return 0;
  const Vector2d direction = line.normalized();
  Vector2d at = from;
  for (int walls = 0; walls <= at_most; ++walls) {
    const double hit = plan.cast(at, direction, left);
    if (!(hit < left)) return walls;
    at += (hit + 1e-3) * direction;
    left -= hit + 1e-3;
    if (left <= 0.0) return walls + 1;
  }
  return at_most + 1;
}

// Whether a mirror image is visible: the line to it meets its mirror, and no wall before it.
bool seen_in_mirror(const FloorPlan& plan, const Reflector& ghost, const Vector2d& from) {
  const Segment& wall = plan.segments()[ghost.mirror];
  const Vector2d along = wall.b_m - wall.a_m, line = ghost.at_m - from;
  const auto cross = [](const Vector2d& a, const Vector2d& b) {
    return a.x() * b.y() - a.y() * b.x();
  };
  const double det = cross(line, along);
  if (std::abs(det) < 1e-9) return false;
  const double t = cross(wall.a_m - from, along) / det, u = cross(wall.a_m - from, line) / det;
  if (!(t > 0.0 && t < 1.0 && u > 0.0 && u < 1.0)) return false;
  return walls_between(plan, from, from + t * line, 0) == 0;
}

double db_to_amplitude(double db) { return std::pow(10.0, 0.05 * db); }

class Illumination {
 public:
  Illumination(const FloorPlan& plan, const SE2d& T_plan_radar, const Vector2d& velocity_m_s,
               const RadarParams& params)
      : plan_(plan),
        params_(params),
        from_(T_plan_radar),
        to_(T_plan_radar.inverse()),
        velocity_(velocity_m_s) {}

  /// False if the echo is negligible.
  bool echo(const Reflector& reflector, std::size_t index, double max_range_m, Echo& echo) const {
    const Vector2d p = to_ * reflector.at_m;
    const double range = p.norm();
    if (p.x() <= 0.0 || range > max_range_m || range > reflector.max_range_m || range < 0.1)
      return false;
    const Vector2d u = p / range;
    double db = reflector.strength_db - 40.0 * std::log10(range) +
                10.0 * params_.beam_exponent * std::log10(u.x());
    if (reflector.sharpness > 0.0) {
      const double facing = std::abs((from_.rotation() * u).dot(reflector.normal));
      db += 10.0 * reflector.sharpness * std::log10(std::max(facing, 1e-6));
    }
    constexpr double kWeakest_db = -10.0;
    if (db < kWeakest_db || !visible(reflector, db) || db < kWeakest_db) return false;
    echo.range_bins = range / params_.range_bin_m;
    echo.doppler_bins = -velocity_.dot(u) / params_.doppler_bin_m_s;
    echo.sine = u.y();
    echo.amplitude = db_to_amplitude(db);
    // Two-way; the reflectors' ranges differ by more than the millimetres of their positions.
    const double own = 2.399963 * static_cast<double>(index);
    echo.phase = std::remainder(4.0 * kPi * range / params_.wavelength_m + own, 2.0 * kPi);
    return true;
  }

 private:
  bool visible(const Reflector& reflector, double& db) const {
    const Vector2d& from = from_.translation();
    if (reflector.mirror != Reflector::kNoMirror) return seen_in_mirror(plan_, reflector, from);
    const int walls = walls_between(plan_, from, reflector.at_m, params_.walls_seen_through);
    db -= walls * params_.wall_loss_db;
    return walls <= params_.walls_seen_through;
  }

  const FloorPlan& plan_;
  const RadarParams& params_;
  SE2d from_, to_;
  Vector2d velocity_;
};

}  // namespace

RadarScan simulate_radar(const FloorPlan& plan, std::span<const Reflector> reflectors,
                         const SE2d& T_plan_radar, const Vector2d& velocity_m_s, LogTime time,
                         const RadarParams& params, Rng& rng) {
  WAYFARE_EXPECTS(params.range_bin_m > 0.0 && params.doppler_bin_m_s > 0.0 &&
                      params.doppler_bins > 2 * (params.doppler_guard + params.doppler_window) &&
                      params.azimuth_bins >= kAntennas && params.max_range_m > 0.0,
                  "a radar's cells have sizes, and more Doppler bins than its threshold looks at");
  const std::size_t beyond = params.range_guard + params.range_window;
  const double seen_m = params.max_range_m + static_cast<double>(beyond) * params.range_bin_m;
  Cube cube(static_cast<std::size_t>(seen_m / params.range_bin_m) + 1, params.doppler_bins, rng);
  const Illumination illumination(plan, T_plan_radar, velocity_m_s, params);
  Echo echo{};
  for (std::size_t i = 0; i < reflectors.size(); ++i)
    if (illumination.echo(reflectors[i], i, seen_m, echo)) add_echo(cube, echo);
  return {time, detect(cube, params)};
}

}  // namespace wayfare::sim
