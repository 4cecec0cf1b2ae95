#pragma once

#include <cmath>
#include <cstddef>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/so3.hpp>

namespace wayfare::eval {

/// Attitude error by Laidig et al. 2021 ("BROAD", section 4): the total angle of the error
/// quaternion in world axes with z up (or down), its part about the vertical, and the inclination
/// error.
struct AttitudeError {
  Angle total;
  Angle heading;
  Angle inclination;
};

[[nodiscard]] inline AttitudeError attitude_error(const SO3d& q_world_body, const SO3d& truth) {
  const auto q = (q_world_body * truth.inverse()).quaternion();
  // Angles from both sine and cosine, since an arc cosine near one is accurate to 1e-8 only.
  const double level = std::hypot(q.x(), q.y());
  return {Angle::radians(2.0 * std::atan2(q.vec().norm(), std::abs(q.w()))),
          Angle::radians(2.0 * std::atan2(std::abs(q.z()), std::abs(q.w()))),
          Angle::radians(2.0 * std::atan2(level, std::hypot(q.w(), q.z())))};
}

/// Root mean squares of attitude errors.
class AttitudeRmse {
 public:
  void add(const AttitudeError& e) {
    total_ += e.total.radians() * e.total.radians();
    heading_ += e.heading.radians() * e.heading.radians();
    inclination_ += e.inclination.radians() * e.inclination.radians();
    ++count_;
  }
  [[nodiscard]] std::size_t count() const { return count_; }
  /// NaN without errors.
  [[nodiscard]] AttitudeError value() const {
    const auto root = [&](double sum) {
      return Angle::radians(std::sqrt(sum / static_cast<double>(count_)));
    };
    return {root(total_), root(heading_), root(inclination_)};
  }

 private:
  double total_ = 0.0, heading_ = 0.0, inclination_ = 0.0;
  std::size_t count_ = 0;
};

}  // namespace wayfare::eval
