#include <wayfare/sim/radar.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "sim/robot/radar_cube.hpp"

namespace wayfare::sim {
namespace {

using Eigen::Vector2d;

constexpr double kPi = std::numbers::pi;

// Mean over the antennas of each cell's power in decibels: the firmware sums logarithms.
std::vector<float> detection_matrix(const Cube& cube) {
  std::vector<float> db(cube.ranges() * cube.dopplers());
  for (std::size_t r = 0; r < cube.ranges(); ++r) {
    for (std::size_t d = 0; d < cube.dopplers(); ++d) {
      const Complex* cell = cube.antennas(r, d);
      double product = 1.0;
      for (std::size_t m = 0; m < kAntennas; ++m)
        product *= static_cast<double>(std::norm(cell[m]));
      db[r * cube.dopplers() + d] =
          static_cast<float>(10.0 / kAntennas * std::log10(std::max(product, 1e-300)));
    }
  }
  return db;
}

// The firmware's detector: constant false alarm rate over range and Doppler, then angles.
class Detector {
 public:
  Detector(const Cube& cube, const RadarParams& params)
      : cube_(cube), params_(params), db_(detection_matrix(cube)) {}

  std::vector<RadarPoint> points() {
    const auto first =
        static_cast<std::size_t>(std::ceil(params_.min_range_m / params_.range_bin_m));
    const auto last = static_cast<std::size_t>(params_.max_range_m / params_.range_bin_m);
    for (std::size_t r = first; r <= last && r < cube_.ranges(); ++r)
      for (std::size_t d = 0; d < cube_.dopplers(); ++d) look_at(r, d);
    if (points_.size() > params_.max_points) points_.resize(params_.max_points);
    return std::move(points_);
  }

 private:
  [[nodiscard]] float at(std::size_t r, std::size_t d) const {
    return db_[r * cube_.dopplers() + d];
  }

  void look_at(std::size_t r, std::size_t d) {
    const double over_range = at(r, d) - range_noise(r, d);
    if (!(over_range > params_.threshold_db)) return;
    if (!(at(r, d) - doppler_noise(r, d) > params_.threshold_db)) return;
    add_points(r, d, over_range);
  }

  // The darker of the two sides, so that the edge of a bright area is detected.
  [[nodiscard]] double range_noise(std::size_t r, std::size_t d) const {
    const auto side = [&](int sign) {
      double sum = 0.0;
      int count = 0;
      for (std::size_t k = 1; k <= params_.range_window; ++k) {
        const auto far = static_cast<int>(params_.range_guard + k);
        const int i = static_cast<int>(r) + sign * far;
        if (i < 0 || i >= static_cast<int>(cube_.ranges())) continue;
        sum += static_cast<double>(at(static_cast<std::size_t>(i), d));
        ++count;
      }
      return count == 0 ? 1e9 : sum / count;
    };
    return std::min(side(-1), side(+1));
  }

  [[nodiscard]] double doppler_noise(std::size_t r, std::size_t d) const {
    const std::size_t n = cube_.dopplers();
    double sum = 0.0;
    for (std::size_t k = 1; k <= params_.doppler_window; ++k) {
      const std::size_t far = params_.doppler_guard + k;
      sum += static_cast<double>(at(r, (d + far) % n) + at(r, (d + n - far % n) % n));
    }
    return sum / (2.0 * static_cast<double>(params_.doppler_window));
  }

  // The highest peak of the angle transform, and the next if nearly as high.
  void add_points(std::size_t r, std::size_t d, double snr_db) {
    const std::vector<double> power = angle_spectrum(cube_.antennas(r, d));
    const std::size_t n = power.size();
    const auto is_peak = [&](std::size_t k) {
      return power[k] >= power[(k + 1) % n] && power[k] > power[(k + n - 1) % n];
    };
    const auto best =
        static_cast<std::size_t>(std::max_element(power.begin(), power.end()) - power.begin());
    add_point(r, d, best, snr_db);
    std::size_t second = n;
    for (std::size_t k = 0; k < n; ++k)
      if (k != best && is_peak(k) && (second == n || power[k] > power[second])) second = k;
    if (second < n && power[second] > params_.second_peak * power[best])
      add_point(r, d, second, snr_db);
  }

  void add_point(std::size_t r, std::size_t d, std::size_t azimuth, double snr_db) {
    const double half = 0.5 * static_cast<double>(params_.azimuth_bins);
    const double sine = static_cast<double>(azimuth) / half - 1.0;
    const Angle bearing = Angle::radians(std::asin(sine));
    if (bearing < params_.min_azimuth || bearing > params_.max_azimuth) return;
    const double range = static_cast<double>(r) * params_.range_bin_m;
    const std::size_t bins = cube_.dopplers();
    const double doppler =
        static_cast<double>(d) - (d >= bins / 2 ? static_cast<double>(bins) : 0.0);
    points_.push_back({static_cast<float>(range * std::sqrt(1.0 - sine * sine)),
                       static_cast<float>(range * sine), 0.0F,
                       static_cast<float>(doppler * params_.doppler_bin_m_s),
                       static_cast<float>(std::round(snr_db * 10.0) / 10.0)});
  }

  [[nodiscard]] std::vector<double> angle_spectrum(const Complex* cell) const {
    std::vector<double> power(params_.azimuth_bins);
    const double half = 0.5 * static_cast<double>(params_.azimuth_bins);
    for (std::size_t k = 0; k < power.size(); ++k) {
      const double sine = static_cast<double>(k) / half - 1.0;
      const std::complex<double> step = std::polar(1.0, -kPi * sine);
      std::complex<double> turn = 1.0, sum = 0.0;
      for (std::size_t m = 0; m < kAntennas; ++m, turn *= step)
        sum += turn * std::complex<double>(cell[m]);
      power[k] = std::norm(sum);
    }
    return power;
  }

  const Cube& cube_;
  const RadarParams& params_;
  std::vector<float> db_;
  std::vector<RadarPoint> points_;
};

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
  if (ghost.mirror >= plan.segments().size()) return false;  // of another plan
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

  /// False if the echo is negligible, or not finite.
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
    const Vector2d moved = to_.rotation() * reflector.velocity_m_s - velocity_;
    echo.doppler_bins = moved.dot(u) / params_.doppler_bin_m_s;
    echo.sine = u.y();
    echo.amplitude = db_to_amplitude(db);
    constexpr double kFastest_bins = 1e6;
    if (!std::isfinite(echo.range_bins + echo.amplitude) ||
        !(std::abs(echo.doppler_bins) < kFastest_bins))
      return false;
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
  constexpr double kMaxRangeCells = 1e5;
  constexpr std::size_t kMaxBins = 1024;
  WAYFARE_EXPECTS(seen_m / params.range_bin_m < kMaxRangeCells && params.min_range_m >= 0.0 &&
                      params.min_range_m / params.range_bin_m < kMaxRangeCells &&
                      params.doppler_bins <= kMaxBins && params.azimuth_bins <= kMaxBins,
                  "a radar has up to 1e5 range cells and 1024 bins");
  Cube cube(static_cast<std::size_t>(seen_m / params.range_bin_m) + 1, params.doppler_bins, rng);
  const Illumination illumination(plan, T_plan_radar, velocity_m_s, params);
  Echo echo{};
  for (std::size_t i = 0; i < reflectors.size(); ++i)
    if (illumination.echo(reflectors[i], i, seen_m, echo)) add_echo(cube, echo);
  return {time, Detector(cube, params).points()};
}

}  // namespace wayfare::sim
