#include <wayfare/sim/radar.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstdint>
#include <numbers>
#include <vector>

namespace wayfare::sim {
namespace {

using Complex = std::complex<float>;
using Eigen::Vector2d;

constexpr double kPi = std::numbers::pi;
constexpr std::size_t kAntennas = 8;  // two transmitters by four receivers, half a wavelength apart

// Response of a windowed transform of `length` samples to a tone `offset` bins away, 1 at 0,
// without its phase, which is the same for all tones of a bin: sum over n of w(n) cos(2 pi offset
// (n - m) / N) about the middle m, for a window that is a sum of cosines.
template <std::size_t Terms>
double window_response(const std::array<double, Terms>& cosines, std::size_t length,
                       double offset) {
  const double last = static_cast<double>(length - 1), middle = 0.5 * last;
  double sum = 0.0, gain = 0.0;
  for (std::size_t n = 0; n < length; ++n) {
    double w = 0.0;
    for (std::size_t k = 0; k < Terms; ++k)
      w += cosines[k] * std::cos(2.0 * kPi * static_cast<double>(k * n) / last);
    gain += w;
    sum += w * std::cos(2.0 * kPi * offset * (static_cast<double>(n) - middle) /
                        static_cast<double>(length));
  }
  return sum / gain;
}

// The response in steps of 1/64 bin, looked up to the nearest.
class Kernel {
 public:
  template <std::size_t Terms>
  Kernel(const std::array<double, Terms>& cosines, std::size_t length, double half_width)
      : half_width_(half_width) {
    const auto steps = static_cast<std::size_t>(half_width * kSteps);
    for (std::size_t i = 0; i <= steps; ++i)
      values_.push_back(
          static_cast<float>(window_response(cosines, length, static_cast<double>(i) / kSteps)));
  }
  [[nodiscard]] double half_width() const { return half_width_; }
  [[nodiscard]] float operator()(double offset) const {
    const auto i = static_cast<std::size_t>(std::abs(offset) * kSteps + 0.5);
    return i < values_.size() ? values_[i] : 0.0F;
  }

 private:
  static constexpr double kSteps = 64.0;
  double half_width_;
  std::vector<float> values_;
};

// The firmware's windows: Blackman over the samples of a chirp, Hann over the chirps.
const Kernel& range_kernel() {
  static const Kernel kernel(std::array{0.42, -0.5, 0.08}, 256, 3.0);
  return kernel;
}
const Kernel& doppler_kernel() {
  static const Kernel kernel(std::array{0.5, -0.5}, 16, 3.0);
  return kernel;
}

// Complex normal deviates of unit power. Frames draw stretches of one long list, which costs a
// hundredth of drawing each number; a stretch comes again after a million draws.
std::span<const Complex> noise_list() {
  static const std::vector<Complex> list = [] {
    Rng rng(20190411);
    std::vector<Complex> values(1U << 16U);
    const double sigma = std::sqrt(0.5);
    for (Complex& v : values) {
      const double re = rng.normal(0.0, sigma);
      v = Complex(static_cast<float>(re), static_cast<float>(rng.normal(0.0, sigma)));
    }
    return values;
  }();
  return list;
}

// One frame's signal: range bins by Doppler bins by antennas.
class Cube {
 public:
  Cube(std::size_t ranges, std::size_t dopplers, Rng& rng)
      : ranges_(ranges), dopplers_(dopplers), cells_(ranges * dopplers * kAntennas) {
    const std::span<const Complex> noise = noise_list();
    const std::size_t row = dopplers * kAntennas;
    for (std::size_t r = 0; r < ranges; ++r) {
      const std::size_t from = rng.below(noise.size() - row);
      std::copy_n(noise.begin() + static_cast<std::ptrdiff_t>(from), row, &cells_[r * row]);
    }
  }
  [[nodiscard]] std::size_t ranges() const { return ranges_; }
  [[nodiscard]] std::size_t dopplers() const { return dopplers_; }
  [[nodiscard]] Complex* antennas(std::size_t range, std::size_t doppler) {
    return &cells_[(range * dopplers_ + doppler) * kAntennas];
  }
  [[nodiscard]] const Complex* antennas(std::size_t range, std::size_t doppler) const {
    return &cells_[(range * dopplers_ + doppler) * kAntennas];
  }

 private:
  std::size_t ranges_, dopplers_;
  std::vector<Complex> cells_;
};

// What comes back from one reflector.
struct Echo {
  double range_bins, doppler_bins, sine;
  double amplitude, phase;
};

void add_echo(Cube& cube, const Echo& echo) {
  const Kernel &in_range = range_kernel(), &in_doppler = doppler_kernel();
  std::array<Complex, kAntennas> steering;
  for (std::size_t m = 0; m < kAntennas; ++m) {
    const double phase = echo.phase + kPi * static_cast<double>(m) * echo.sine;
    steering[m] = Complex(std::polar(echo.amplitude, phase));
  }
  const auto bins = static_cast<int>(cube.dopplers());
  const int d0 = static_cast<int>(std::ceil(echo.doppler_bins - in_doppler.half_width()));
  const int d1 = static_cast<int>(std::floor(echo.doppler_bins + in_doppler.half_width()));
  const int r0 = std::max(0, static_cast<int>(std::ceil(echo.range_bins - in_range.half_width())));
  const int r1 = std::min(static_cast<int>(cube.ranges()) - 1,
                          static_cast<int>(std::floor(echo.range_bins + in_range.half_width())));
  for (int d = d0; d <= d1; ++d) {
    const float gain = in_doppler(echo.doppler_bins - d);
    // The second transmitter sends half a chirp pair later; the firmware turns its phase back by
    // the bin's Doppler, not by the echo's own.
    const double late = 2.0 * kPi * (echo.doppler_bins - d) / (2.0 * bins);
    const Complex second(static_cast<float>(std::cos(late)), static_cast<float>(std::sin(late)));
    const auto doppler = static_cast<std::size_t>((d % bins + bins) % bins);
    for (int r = r0; r <= r1; ++r) {
      const float g = gain * in_range(echo.range_bins - r);
      Complex* cell = cube.antennas(static_cast<std::size_t>(r), doppler);
      for (std::size_t m = 0; m < kAntennas / 2; ++m) cell[m] += g * steering[m];
      for (std::size_t m = kAntennas / 2; m < kAntennas; ++m) cell[m] += g * (steering[m] * second);
    }
  }
}

// Walls between two points, counted up to one more than `at_most`.
int walls_between(const FloorPlan& plan, const Vector2d& from, const Vector2d& to, int at_most) {
  constexpr double kOwnWall_m = 0.03;  // what a reflector sits on does not hide it
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

// Whether the mirror image is seen in its wall: the line to it meets the wall, and nothing before.
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

  /// False where nothing worth adding comes back.
  bool echo(const Reflector& reflector, std::size_t index, double farthest_m, Echo& echo) const {
    const Vector2d p = to_ * reflector.at_m;
    const double range = p.norm();
    if (p.x() <= 0.0 || range > farthest_m || range > reflector.farthest_m || range < 0.1)
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
    // There and back; reflectors differ by more than the millimetres their places are given to.
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

// Mean over the antennas of each cell's power in decibels, as the firmware sums logarithms.
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

  // The darker side of the two, so that the edge of something bright is found.
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

  // The highest peak of the angle transform, and the next where it is nearly as high.
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
  return {time, Detector(cube, params).points()};
}

}  // namespace wayfare::sim
