#pragma once

// The receivers' signals in one frame, after the firmware's transforms over range and Doppler.

#include <complex>
#include <cstddef>
#include <vector>

#include <wayfare/core/random.hpp>

namespace wayfare::sim {

using Complex = std::complex<float>;

/// Two transmitters and four receivers, half a wavelength apart.
inline constexpr std::size_t kAntennas = 8;

/// The signal of one frame: range bins by Doppler bins by antennas.
class Cube {
 public:
  /// Of noise of unit power.
  Cube(std::size_t ranges, std::size_t dopplers, Rng& rng);
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

/// The echo of one reflector.
struct Echo {
  double range_bins, doppler_bins, sine;
  double amplitude, phase;
};

void add_echo(Cube& cube, const Echo& echo);

}  // namespace wayfare::sim
