#pragma once

#include <cstddef>
#include <vector>

#include <wayfare/core/se2.hpp>

namespace wayfare {

/// Poses and log weights as a structure of arrays.
struct ParticleSet {
  std::vector<double> x_m, y_m, heading_rad, log_weight;

  [[nodiscard]] std::size_t size() const { return x_m.size(); }
  [[nodiscard]] bool empty() const { return x_m.empty(); }
  [[nodiscard]] SE2d pose(std::size_t i) const {
    return {x_m[i], y_m[i], Angle::radians(heading_rad[i])};
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
    log_weight.assign(n, 0.0);
  }
  void push_back(const SE2d& pose) {
    x_m.push_back(pose.x());
    y_m.push_back(pose.y());
    heading_rad.push_back(pose.heading().radians());
    log_weight.push_back(0.0);
  }
};

}  // namespace wayfare
