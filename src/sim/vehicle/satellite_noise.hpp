#pragma once

// Errors of one satellite's measurements over the epochs.

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <wayfare/core/random.hpp>
#include <wayfare/sim/gnss.hpp>

namespace wayfare::sim {

class SatelliteNoise {
 public:
  explicit SatelliteNoise(const Rng& rng) : white_(rng.stream(0)), bursts_(rng.stream(1)) {}

  void step(double range_sigma_m, double rate_sigma_mps, const MultipathBursts& multipath,
            double seconds) {
    range_m = white_.normal(0.0, range_sigma_m);
    rate_mps = white_.normal(0.0, rate_sigma_mps);
    burst_left_s_ -= seconds;
    const double begin = bursts_.uniform(), length = bursts_.uniform(), size = bursts_.uniform();
    if (burst_left_s_ <= 0.0) {
      excess_m_ = 0.0;
      if (begin < -std::expm1(-multipath.per_satellite_hour * seconds / 3600.0)) {
        burst_left_s_ = -multipath.mean_duration_s * std::log1p(-length);
        excess_m_ = -multipath.mean_excess_m * std::log1p(-size);
      }
    }
    range_m += excess_m_;
  }

  double range_m = 0.0, rate_mps = 0.0;

 private:
  Rng white_, bursts_;
  double burst_left_s_ = 0.0, excess_m_ = 0.0;
};

/// One per satellite, with streams from `first_stream` on.
[[nodiscard]] inline std::vector<SatelliteNoise> satellite_noises(const Rng& rng,
                                                                  std::uint64_t first_stream,
                                                                  std::size_t count) {
  std::vector<SatelliteNoise> noises;
  for (std::size_t i = 0; i < count; ++i) noises.emplace_back(rng.stream(first_stream + i));
  return noises;
}

}  // namespace wayfare::sim
