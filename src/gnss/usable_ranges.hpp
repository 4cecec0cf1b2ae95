#pragma once

// Private: what of an epoch a solution can use.

#include <array>
#include <cstddef>
#include <utility>

#include <Eigen/Core>

#include <wayfare/sensors/measurements.hpp>

namespace wayfare {

/// Beyond every orbit, and every error of a receiver's clock.
inline constexpr double kFarthest_m = 1e9;

[[nodiscard]] inline bool is_place(const Eigen::Vector3d& p) {
  return p.allFinite() && p.cwiseAbs().maxCoeff() < kFarthest_m;
}

/// Whether a satellite comes for the first time: measurements of one are not independent.
struct FirstOnly {
  std::array<std::array<bool, 256>, kGnssSystems> seen{};
  [[nodiscard]] bool operator()(SatelliteId s) {
    return !std::exchange(seen[static_cast<std::size_t>(s.system)][s.number], true);
  }
};

}  // namespace wayfare
