#pragma once

#include <cstddef>
#include <vector>

#include <wayfare/core/random.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/filter/pose_bins.hpp>
#include <wayfare/slam/localisation.hpp>

namespace wayfare {

/// Poses and log weights as a structure of arrays, as the kernels of likelihood fields read them.
struct ParticleSet {
  using Value = SE2d;
  std::vector<double> x_m, y_m, heading_rad, log_weights;

  [[nodiscard]] std::size_t size() const { return x_m.size(); }
  [[nodiscard]] bool empty() const { return x_m.empty(); }
  [[nodiscard]] SE2d state(std::size_t i) const {
    return {x_m[i], y_m[i], Angle::radians(heading_rad[i])};
  }
  [[nodiscard]] PoseBins::Key key(std::size_t i, const PoseBins& bins) const {
    return bins.of(x_m[i], y_m[i], heading_rad[i]);
  }
  void set(std::size_t i, const SE2d& pose) {
    x_m[i] = pose.x();
    y_m[i] = pose.y();
    heading_rad[i] = pose.heading().radians();
  }
  void resize(std::size_t n) {
    x_m.resize(n);
    y_m.resize(n);
    heading_rad.resize(n);
    log_weights.assign(n, 0.0);
  }
  void push_back(const SE2d& pose) {
    x_m.push_back(pose.x());
    y_m.push_back(pose.y());
    heading_rad.push_back(pose.heading().radians());
    log_weights.push_back(0.0);
  }

  /// Particle i with normal noise.
  [[nodiscard]] SE2d with_noise(std::size_t i, double sigma_m, double sigma_rad, Rng& rng) const {
    const double x = x_m[i] + sigma_m * rng.normal();
    const double y = y_m[i] + sigma_m * rng.normal();
    return {x, y, Angle::radians(heading_rad[i] + sigma_rad * rng.normal())};
  }
  /// Poses evenly spread over the map's free cells, each at a random heading.
  [[nodiscard]] static ParticleSet anywhere(const LocalisationMap& map,
                                            const MonteCarloOptions& options, const Rng& rng);
};

}  // namespace wayfare
