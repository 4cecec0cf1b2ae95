#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/se2.hpp>

namespace wayfare::calibration {

/// A dual number's value, or the number itself.
inline double value_of(double x) { return x; }
template <class T>
double value_of(const T& x) {
  return x.value;
}

/// Rates of the base between two times: of two wheels (m/s as reported), or those of a body whose
/// motion is known (m/s, m/s, rad/s).
struct BaseStep {
  double begin_s = 0.0, end_s = 0.0;
  Eigen::Vector3d rates = Eigen::Vector3d::Zero();
  [[nodiscard]] double middle_s() const { return 0.5 * (begin_s + end_s); }
};

/// The base's motion over time, as a function of the wheels' parameters (scale left, scale right,
/// base). Steps are in order and without overlap.
class BaseMotion {
 public:
  BaseMotion() = default;
  BaseMotion(const std::vector<BaseStep>& steps, bool wheels, double largest_gap_s)
      : wheels_(wheels) {
    for (const BaseStep& step : steps) {
      if (!steps_.empty() && step.begin_s > steps_.back().end_s)
        append({steps_.back().end_s, step.begin_s}, false);
      append(step, step.end_s - step.begin_s <= largest_gap_s);
    }
  }

  [[nodiscard]] bool by_wheels() const { return wheels_; }
  [[nodiscard]] bool empty() const { return steps_.empty(); }
  [[nodiscard]] std::span<const BaseStep> steps() const { return steps_; }
  /// Whether the motion is known from one time to the other.
  [[nodiscard]] bool covers(double from_s, double to_s) const {
    if (steps_.size() < 2 || from_s < steps_.front().begin_s || to_s > steps_.back().end_s)
      return false;
    return unknown_[index(to_s) + 1] == unknown_[index(from_s)];
  }

  /// Twist of the base for reported rates.
  template <class T>
  [[nodiscard]] Eigen::Matrix<T, 3, 1> twist(const Eigen::Matrix<T, 3, 1>& rates,
                                             const Eigen::Matrix<T, 3, 1>& wheels) const {
    if (!wheels_) return rates;
    const T left = wheels[0] * rates[0], right = wheels[1] * rates[1];
    return {T(0.5) * (left + right), T(0), (right - left) / wheels[2]};
  }

  /// At an instant, linear between the means of neighbouring steps.
  template <class T>
  [[nodiscard]] Eigen::Matrix<T, 3, 1> twist_at(const T& time_s,
                                                const Eigen::Matrix<T, 3, 1>& wheels) const {
    return twist(rates_at(segment(value_of(time_s)), time_s), wheels);
  }

  /// T_from_to, along arcs, with rates that are linear between the middles of steps. (Constant
  /// rates would be least noisy between two samples and noisiest at one, which biases delays to
  /// half a step.)
  template <class T>
  [[nodiscard]] SE2<T> between(const T& from_s, const T& to_s,
                               const Eigen::Matrix<T, 3, 1>& wheels) const {
    SE2<T> moved;
    T at = from_s;
    const double end = value_of(to_s);
    for (std::size_t k = segment(value_of(from_s));; ++k) {
      const bool last = k + 2 >= steps_.size() || steps_[k + 1].middle_s() >= end;
      const T until = last ? to_s : T(steps_[k + 1].middle_s());
      const Eigen::Matrix<T, 3, 1> tau = twist(rates_at(k, T(T(0.5) * (at + until))), wheels);
      moved = moved * SE2<T>::exp(Eigen::Matrix<T, 3, 1>((until - at) * tau));
      if (last) return moved;
      at = until;
    }
  }

 private:
  void append(const BaseStep& step, bool known) {
    steps_.push_back(step);
    unknown_.push_back(unknown_.back() + (known ? 0 : 1));
  }
  /// The step that contains the time, or the nearest.
  [[nodiscard]] std::size_t index(double time_s) const {
    const auto after = std::partition_point(steps_.begin(), steps_.end(),
                                            [&](const BaseStep& s) { return s.end_s <= time_s; });
    return std::min(static_cast<std::size_t>(after - steps_.begin()), steps_.size() - 1);
  }

  /// The step from whose middle to that of the next the time is; there are two steps or more.
  [[nodiscard]] std::size_t segment(double time_s) const {
    std::size_t k = index(time_s);
    if (k > 0 && time_s < steps_[k].middle_s()) --k;
    return std::min(k, steps_.size() - 2);
  }
  template <class T>
  [[nodiscard]] Eigen::Matrix<T, 3, 1> rates_at(std::size_t k, const T& time_s) const {
    const BaseStep &a = steps_[k], &b = steps_[k + 1];
    const T u = (time_s - T(a.middle_s())) / T(b.middle_s() - a.middle_s());
    Eigen::Matrix<T, 3, 1> rates;
    for (int i = 0; i < 3; ++i) rates[i] = T(a.rates[i]) + u * T(b.rates[i] - a.rates[i]);
    return rates;
  }

  std::vector<BaseStep> steps_;
  std::vector<int> unknown_{0};  // number of steps of unknown motion before each
  bool wheels_ = true;
};

}  // namespace wayfare::calibration
