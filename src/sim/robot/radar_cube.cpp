#include "sim/robot/radar_cube.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>

namespace wayfare::sim {
namespace {

// Response of a windowed transform of `length` samples to a tone `offset` bins away, 1 at 0,
// Without its phase, which is the same for all tones of a bin: sum over n of w(n) cos(2 pi offset
// (n - m) / N) about the middle m, for a window that is a sum of cosines.
template <std::size_t Terms>
double window_response(const std::array<double, Terms>& cosines, std::size_t length,
                       double offset) {
  const double last = static_cast<double>(length - 1), middle = 0.5 * last;
  double sum = 0.0, gain = 0.0;
  for (std::size_t n = 0; n < length; ++n) {
    double w = 0.0;
    for (std::size_t k = 0; k < Terms; ++k)
      w += cosines[k] * std::cos(2.0 * std::numbers::pi * static_cast<double>(k * n) / last);
    gain += w;
    sum += w * std::cos(2.0 * std::numbers::pi * offset * (static_cast<double>(n) - middle) /
                        static_cast<double>(length));
  }
  return sum / gain;
}

// The response tabulated in steps of 1/64 bin, nearest entry.
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
    // NOLINTNEXTLINE(bugprone-incorrect-roundings): not negative
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

// Complex normal numbers of unit power. Frames use random parts of one long list, at a hundredth of
// the cost of drawing each number; a part repeats after a million draws.
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

}  // namespace

Cube::Cube(std::size_t ranges, std::size_t dopplers, Rng& rng)
    : ranges_(ranges), dopplers_(dopplers), cells_(ranges * dopplers * kAntennas) {
  const std::span<const Complex> noise = noise_list();
  const std::size_t row = dopplers * kAntennas;
  for (std::size_t r = 0; r < ranges; ++r) {
    const std::size_t from = rng.below(noise.size() - row);
    std::copy_n(noise.begin() + static_cast<std::ptrdiff_t>(from), row, &cells_[r * row]);
  }
}

void add_echo(Cube& cube, const Echo& echo) {
  const Kernel &in_range = range_kernel(), &in_doppler = doppler_kernel();
  std::array<Complex, kAntennas> steering;
  for (std::size_t m = 0; m < kAntennas; ++m) {
    const double phase = echo.phase + std::numbers::pi * static_cast<double>(m) * echo.sine;
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
    // The second transmitter sends half a chirp pair later; the firmware compensates this phase
    // with the bin's Doppler, not with the echo's own.
    const double late = 2.0 * std::numbers::pi * (echo.doppler_bins - d) / (2.0 * bins);
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

}  // namespace wayfare::sim
