#pragma once

// Means of a unit's readings over any interval, by sums since the start.

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/statistics.hpp>
#include <wayfare/sensors/measurements.hpp>

namespace wayfare::nav {

struct UnitMean {
  Eigen::Vector3d rate_radps = Eigen::Vector3d::Zero();
  Eigen::Vector3d force_mps2 = Eigen::Vector3d::Zero();
};

class UnitMeans {
 public:
  /// Times count from `origin`, after the addition of `offset_s`.
  UnitMeans(std::span<const ImuSample> samples, LogTime origin, double offset_s) {
    constexpr double kLargest = 1e6;
    const ImuSample* last = nullptr;
    std::vector<double> steps;
    for (const ImuSample& s : samples) {
      if (!(s.angular_rate_radps.cwiseAbs().maxCoeff() < kLargest) ||
          !(s.specific_force_mps2.cwiseAbs().maxCoeff() < kLargest) ||
          !s.angular_rate_radps.allFinite() || !s.specific_force_mps2.allFinite())
        continue;
      const double dt = last != nullptr ? to_seconds(s.time - last->time) : 0.0;
      if (last != nullptr && dt <= 0.0) continue;
      Sum sum = sums_.empty() ? Sum{} : sums_.back();
      sum.time_s = to_seconds(s.time - origin) + offset_s;
      if (last != nullptr) {
        sum.angle_rad += 0.5 * dt * (last->angular_rate_radps + s.angular_rate_radps);
        sum.velocity_mps += 0.5 * dt * (last->specific_force_mps2 + s.specific_force_mps2);
        steps.push_back(dt);
      }
      sums_.push_back(sum);
      last = &s;
    }
    const double step = steps.empty() ? 0.0 : upper_median_of(steps);
    gap_s_ = std::max(5.0 * step, 0.1);
    int gaps = 0;
    for (std::size_t i = 1; i < sums_.size(); ++i) {
      if (sums_[i].time_s - sums_[i - 1].time_s > gap_s_) ++gaps;
      sums_[i].gaps = gaps;
    }
  }

  [[nodiscard]] bool empty() const { return sums_.size() < 2; }
  [[nodiscard]] double begin_s() const { return sums_.front().time_s; }
  [[nodiscard]] double end_s() const { return sums_.back().time_s; }

  /// Nothing outside the readings or across a gap.
  [[nodiscard]] std::optional<UnitMean> over(double begin_s, double end_s) const {
    if (empty() || !(begin_s >= this->begin_s()) || !(end_s <= this->end_s()) || !(begin_s < end_s))
      return std::nullopt;
    const Sum a = at(begin_s), b = at(end_s);
    if (a.gaps != b.gaps) return std::nullopt;
    const double dt = end_s - begin_s;
    return UnitMean{(b.angle_rad - a.angle_rad) / dt, (b.velocity_mps - a.velocity_mps) / dt};
  }

 private:
  struct Sum {
    double time_s = 0.0;
    Eigen::Vector3d angle_rad = Eigen::Vector3d::Zero();
    Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();
    int gaps = 0;  ///< before
  };

  [[nodiscard]] Sum at(double time_s) const {
    const auto after = std::lower_bound(sums_.begin() + 1, sums_.end() - 1, time_s,
                                        [](const Sum& s, double t) { return s.time_s < t; });
    const Sum& b = *after;
    const Sum& a = *(after - 1);
    const double part = (time_s - a.time_s) / (b.time_s - a.time_s);
    return {time_s, a.angle_rad + part * (b.angle_rad - a.angle_rad),
            a.velocity_mps + part * (b.velocity_mps - a.velocity_mps), b.gaps};
  }

  std::vector<Sum> sums_;
  double gap_s_ = 0.1;
};

}  // namespace wayfare::nav
