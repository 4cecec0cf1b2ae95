#include "sim/robot/radar_detector.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace wayfare::sim {
namespace {

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

std::vector<RadarPoint> detect(const Cube& cube, const RadarParams& params) {
  return Detector(cube, params).points();
}

}  // namespace wayfare::sim
