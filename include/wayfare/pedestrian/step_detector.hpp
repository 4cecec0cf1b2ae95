#pragma once

// Step detection from the magnitude of the specific force, anywhere on the body, and models of the
// step length, which are const callables.

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <optional>
#include <span>
#include <variant>

#include <Eigen/Core>

#include <wayfare/core/time.hpp>
#include <wayfare/inertial/attitude.hpp>
#include <wayfare/inertial/detail/sample_clock.hpp>
#include <wayfare/pedestrian/detail/swings.hpp>
#include <wayfare/pedestrian/step.hpp>

namespace wayfare {

/// Causal; allocates no memory. A step is reported a fifth of a second after its crest, the first
/// ones of a walk together once there are enough of them.
class StepDetector {
 public:
  /// Without readings.
  explicit StepDetector(const StepParameters& parameters = {})
      : p_(parameters), band_(parameters), onset_(parameters) {}

  /// Passes newly detected steps to `sink(const Step&)`.
  template <class Sink>
  UpdateStatus add(LogTime time, const Eigen::Vector3d& force_mps2, Sink&& sink) {
    if (!force_mps2.allFinite()) return UpdateStatus::missing;
    const auto verdict = clock_.check(time);
    if (verdict == SampleClock::Verdict::late) return UpdateStatus::late;
    const bool saturated = force_mps2.cwiseAbs().maxCoeff() >= p_.force_range;
    const double magnitude = force_mps2.cwiseMin(p_.force_range).cwiseMax(-p_.force_range).norm();
    const double dt = clock_.step_s();
    if (verdict == SampleClock::Verdict::first || dt > 0.5) {
      restart(magnitude);
    } else {
      detect(time, magnitude, dt, sink);
    }
    return saturated ? UpdateStatus::saturated : UpdateStatus::used;
  }

  /// Number of steps reported.
  [[nodiscard]] std::uint64_t steps() const { return steps_; }
  /// All steps before this time have been reported; nothing before the first reading. A crest from
  /// which the force has not fallen for half the longest step is not waited for: as after the last
  /// step of a walk. Its step would be late.
  [[nodiscard]] std::optional<LogTime> settled() const {
    if (!clock_.started()) return std::nullopt;
    const LogTime now = clock_.last();
    const LogTime next =
        std::max(band_.crest().value_or(now), now - from_seconds(0.5 * p_.longest_step_s));
    const double since = has_last_ ? to_seconds(next - last_) : p_.longest_step_s;
    if (since >= p_.longest_step_s) return next;
    if (!walking_) return onset_.first();
    return since < p_.hidden_to * recent_interval_s_.value ? last_ : next;
  }
  /// The band-passed magnitude, m/s².
  [[nodiscard]] double band() const { return band_.now(); }

 private:
  /// Exponential mean over the recent steps.
  struct RecentMean {
    double value = 0.0;
    void add(double x, double part) { value += (value > 0.0 ? part : 1.0) * (x - value); }
    /// Limits the influence of one value to twice the mean.
    void add_capped(double x, double part) {
      add(value > 0.0 ? std::min(x, 2.0 * value) : x, part);
    }
  };

  void restart(double magnitude) {
    band_.restart(magnitude);
    walked_ = false;
    begin_walk(false);
  }

  template <class Sink>
  void detect(LogTime time, double magnitude, double dt, Sink&& sink) {
    const auto swing = band_.add(time, magnitude, dt, p_.pass_part * recent_swing_.value);
    const double x = band_.now();
    area_ += std::abs(x) * dt;
    area_s_ += dt;
    trough_ = std::min(trough_, x);
    if (swing) add_swing(*swing, sink);
  }

  template <class Sink>
  void add_swing(const Swing& s, Sink&& sink) {
    const double since = has_last_ ? to_seconds(s.time - last_) : 1e9;
    if (since > p_.longest_step_s)
      begin_walk(walked_ && to_seconds(s.time - walked_until_) < p_.resume_s);
    const double swing = s.crest_mps2 - s.trough_mps2;
    if (s.crest_mps2 < std::max(p_.least_crest, p_.crest_part * recent_crest_.value) ||
        swing < p_.swing_part * recent_swing_.value)
      return;
    const double interval_s = recent_interval_s_.value;
    if (has_last_ && since < std::max(p_.refractory_s, p_.refractory_part * interval_s)) return;
    const bool late = has_last_ && interval_s > 0.0 && since > p_.hidden_from * interval_s;
    const bool hidden = late && walking_ && since < p_.hidden_to * interval_s;
    const double part = 1.0 / p_.memory_steps;
    recent_crest_.add_capped(s.crest_mps2, part);
    recent_swing_.add_capped(swing, part);
    if (has_last_) recent_interval_s_.add(late ? 0.5 * since : since, part);
    const Step step{s.time,
                    has_last_ ? since : 0.0,
                    s.crest_mps2,
                    trough_,
                    area_s_ > 0.0 ? area_ / area_s_ : 0.0,
                    swing};
    trough_ = area_ = area_s_ = 0.0;
    last_ = s.time;
    has_last_ = true;
    report(step, hidden, sink);
  }

  template <class Sink>
  void report(Step step, bool hidden, Sink&& sink) {
    if (walking_) {
      if (hidden) {
        step.interval_s *= 0.5;
        Step before = step;
        before.time = step.time - from_seconds(step.interval_s);
        emit(before, sink);
      }
      emit(step, sink);
      return;
    }
    const auto first = onset_.add(step);
    for (const Step& s : first) emit(s, sink);
    if (!first.empty()) walking_ = walked_ = true;
  }

  template <class Sink>
  void emit(const Step& step, Sink&& sink) {
    walked_until_ = step.time;
    ++steps_;
    sink(step);
  }

  void begin_walk(bool resuming) {
    has_last_ = walking_ = false;
    onset_.clear(resuming);
    if (!resuming) recent_crest_ = recent_swing_ = recent_interval_s_ = {};
    trough_ = area_ = area_s_ = 0.0;
  }

  StepParameters p_;
  SampleClock clock_{1.0};
  BandPassFilter band_;
  GaitStartDetector onset_;
  RecentMean recent_crest_, recent_swing_, recent_interval_s_;
  double trough_ = 0.0, area_ = 0.0, area_s_ = 0.0;
  bool has_last_ = false, walking_ = false, walked_ = false;
  LogTime last_, walked_until_;
  std::uint64_t steps_ = 0;
};

/// Length of a step in metres: any const callable. It is zero or more; the step is dropped where it
/// is not finite. See testing::StepLengthLaws.
template <class M>
concept StepLengthModel = std::copy_constructible<M> && requires(const M& model, const Step& step) {
  { model(step) } -> std::convertible_to<double>;
};

/// A model whose `factor` scales all lengths, so that one calibration serves every such model.
template <class M>
concept ScaledStepLength = StepLengthModel<M> && requires(M model) {
  { model.factor } -> std::same_as<double&>;
};

namespace detail {

/// What a type lacks to be a step length model, in words.
template <class M>
consteval bool check_step_length() {
  static_assert(StepLengthModel<M>,
                "wayfare: a step length model is a value with a const member "
                "operator()(const Step&), which returns the length in metres, a double");
  return true;
}

}  // namespace detail

/// Constant length: distance over number of steps (Sadruddin 2020, 2.6.3).
struct ConstantStep {
  double factor = 0.69;                                             ///< m
  double operator()(const Step& /*step*/) const { return factor; }  ///< m; the step does not matter
};

/// Range of the acceleration within the step: k·(a_max − a_min)^¼ (Weinberg 2002).
struct WeinbergStep {
  double factor = 0.434;  ///< m·(m/s²)^-¼
  /// Length of a step, m.
  double operator()(const Step& s) const {
    return factor * std::pow(std::max(0.0, s.crest_mps2 - s.trough_mps2), 0.25);
  }
};

/// Mean magnitude of the acceleration within the step: k·(Σ|a|/n)^⅓ (Kim et al. 2004).
struct KimStep {
  double factor = 0.545;  ///< m·(m/s²)^-⅓
  /// Length of a step, m.
  double operator()(const Step& s) const {
    return factor * std::cbrt(std::max(0.0, s.mean_abs_mps2));
  }
};

/// Body height and step frequency: k·h·√f (Tian et al. 2015).
struct HeightFrequencyStep {
  double factor = 0.3139;  ///< s^½, of the height times the root of the frequency
  double height_m = 1.75;  ///< of the walker
  /// Length of a step, m; intervals below 0.2 s count as 0.2 s.
  double operator()(const Step& s) const {
    return factor * height_m * std::sqrt(1.0 / std::max(s.interval_s, 0.2));
  }
};

/// One of these models, chosen at run time.
struct StepLength : std::variant<KimStep, ConstantStep, WeinbergStep, HeightFrequencyStep> {
  using variant::variant;
  /// For std::visit.
  [[nodiscard]] variant& models() { return *this; }
  /// For std::visit.
  [[nodiscard]] const variant& models() const { return *this; }
  /// Length by the model chosen, m.
  double operator()(const Step& step) const {
    return std::visit([&](const auto& model) { return model(step); }, models());
  }
};

/// Length of a step by a model, m.
[[nodiscard]] inline double length_of(const Step& step, const StepLength& model) {
  return model(step);
}

/// The model with its factor calibrated so that the steps of a walk add up to its known length.
/// Unchanged if they add up to zero.
template <ScaledStepLength M>
[[nodiscard]] M calibrated(M model, std::span<const Step> steps, double length_m) {
  double sum = 0.0;
  for (const Step& s : steps) sum += model(s);
  if (sum > 0.0 && length_m > 0.0) model.factor *= length_m / sum;
  return model;
}
/// The same for the model chosen at run time.
[[nodiscard]] inline StepLength calibrated(StepLength model, std::span<const Step> steps,
                                           double length_m) {
  std::visit([&](auto& m) { m = calibrated(m, steps, length_m); }, model.models());
  return model;
}

}  // namespace wayfare
