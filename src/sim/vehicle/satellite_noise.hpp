#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include <wayfare/core/random.hpp>
#include <wayfare/filter/gauss_markov.hpp>
#include <wayfare/sim/gnss.hpp>

namespace wayfare::sim {

/// Errors of one satellite's measurements over the epochs.
class SatelliteNoise {
 public:
  explicit SatelliteNoise(const Rng& rng)
      : white_(rng.stream(0)), bursts_(rng.stream(1)), phase_(rng.stream(2)), slow_(rng.stream(3)) {
    cycles = std::floor(phase_.uniform(-1e6, 1e6));
  }

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
  /// Moves an error of unit variance.
  double step_correlated(double tau_s, double seconds) {
    const auto step = discretise_gauss_markov(1.0, tau_s, seconds);
    const double noise = slow_.normal();
    correlated_ = correlated_ ? step.phi * *correlated_ + std::sqrt(step.q) * noise : noise;
    return *correlated_;
  }

  void step_phase(const PhaseParams& params, double seconds) {
    phase_m = phase_.normal(0.0, params.sigma_m);
    const double begin = phase_.uniform(), size = phase_.uniform(-20.0, 20.0);
    const bool slips = begin < -std::expm1(-params.slips_per_satellite_hour * seconds / 3600.0);
    interrupted = phase_.uniform() < params.announced && slips;
    if (slips) cycles += size < 0.0 ? std::floor(size) : std::ceil(size);
  }

  double range_m = 0.0, rate_mps = 0.0;
  double phase_m = 0.0, cycles = 0.0;
  bool interrupted = false;

 private:
  Rng white_, bursts_, phase_, slow_;
  std::optional<double> correlated_;
  double burst_left_s_ = 0.0, excess_m_ = 0.0;
};

/// One per satellite, with streams from `first_stream` on.
inline std::vector<SatelliteNoise> satellite_noises(const Rng& rng, std::uint64_t first_stream,
                                             std::size_t count) {
  std::vector<SatelliteNoise> noises;
  for (std::size_t i = 0; i < count; ++i) noises.emplace_back(rng.stream(first_stream + i));
  return noises;
}

}  // namespace wayfare::sim
