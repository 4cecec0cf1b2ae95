#pragma once

// Plausibility checks of gyro and wheels.

#include <wayfare/nav/corridor_ins.hpp>

namespace wayfare::corridor {

/// Checks consecutive samples.
class MotionWatch {
 public:
  explicit MotionWatch(const CorridorInsOptions& options) : options_(options) {}

  struct Checked {
    CorridorInput input;
    bool saturated = false, slipping = false, slip_began = false;
  };
  /// The step from the previous sample to this one; times are in order.
  [[nodiscard]] Checked check(const MotionSample& sample, Duration step);

 private:
  void check_wheels(const MotionSample& sample, Duration step, Checked& checked);

  CorridorInsOptions options_;
  double speed_m_s_ = 0.0;  ///< last accepted
  Duration standing_{0}, slipping_{0};
};

}  // namespace wayfare::corridor
