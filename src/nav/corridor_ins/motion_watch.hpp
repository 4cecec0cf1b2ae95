#pragma once

// What of gyro and wheels cannot be believed.

#include <wayfare/nav/corridor_ins.hpp>

namespace wayfare::corridor {

/// Judges samples one after another.
class MotionWatch {
 public:
  explicit MotionWatch(const CorridorInsOptions& options) : options_(options) {}

  struct Judged {
    CorridorInput input;
    bool saturated = false, slipping = false, slip_began = false;
  };
  /// The step from the sample before to this one; both times are known to be in order.
  [[nodiscard]] Judged judge(const MotionSample& sample, Duration step);

 private:
  void judge_wheels(const MotionSample& sample, Duration step, Judged& judged);

  CorridorInsOptions options_;
  double speed_m_s_ = 0.0;  ///< last believed
  Duration standing_{0}, slipping_{0};
};

}  // namespace wayfare::corridor
