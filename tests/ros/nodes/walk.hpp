#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include <wayfare/sensors/measurements.hpp>

namespace wayfare::testing {

/// Samples of a unit that bobs twice a second, as a walker's body does.
inline std::vector<ImuSample> walk(double seconds) {
  std::vector<ImuSample> samples;
  for (int i = 0; i < static_cast<int>(100.0 * seconds); ++i) {
    const double t = 0.01 * i;
    const double bob = t < 2.0 ? 0.0 : 3.0 * std::sin(2.0 * std::numbers::pi * 2.0 * t);
    samples.push_back({LogTime::from_seconds(1000.0 + t), Eigen::Vector3d::Zero(),
                       Eigen::Vector3d(0.0, 0.0, 9.81 + bob)});
  }
  return samples;
}

}  // namespace wayfare::testing
