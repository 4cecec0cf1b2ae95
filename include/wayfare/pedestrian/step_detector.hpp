#pragma once

// Steps from the strength of the specific force, wherever on the body it is measured.

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <Eigen/Core>

#include <wayfare/core/time.hpp>
#include <wayfare/inertial/attitude.hpp>
#include <wayfare/inertial/detail/sample_clock.hpp>
#include <wayfare/pedestrian/detail/band_pass_filter.hpp>
#include <wayfare/pedestrian/detail/gait_start_detector.hpp>
#include <wayfare/pedestrian/step.hpp>

namespace wayfare {

/// Causal and without memory beyond itself. A step is announced a fifth of a second after its
/// crest, the first ones of a walk together once there are enough of them.
class StepDetector {
 public:
  explicit StepDetector(const StepParameters& parameters = {})
      : p_(parameters), band_(parameters), onset_(parameters) {}

  /// Hands the steps that are now known to `sink(const Step&)`.
  template <class Sink>
  UpdateStatus add(LogTime time, const Eigen::Vector3d& force_mps2, Sink&& sink) {
    if (!force_mps2.allFinite()) return UpdateStatus::missing;
    const auto verdict = clock_.check(time);
    if (verdict == SampleClock::Verdict::late) return UpdateStatus::late;
    const bool saturated = force_mps2.cwiseAbs().maxCoeff() >= p_.force_range;
    const double strength = force_mps2.cwiseMin(p_.force_range).cwiseMax(-p_.force_range).norm();
    const double dt = clock_.step_s();
    if (verdict == SampleClock::Verdict::first || dt > 0.5) {
      restart(strength);
    } else {
      follow(time, strength, dt, sink);
    }
    return saturated ? UpdateStatus::saturated : UpdateStatus::used;
  }

  [[nodiscard]] std::uint64_t steps() const { return steps_; }
  /// The band-limited strength, m/s².
  [[nodiscard]] double band() const { return band_.now(); }

 private:
  /// Mean over the last steps, once there is one.
  struct Usual {
    double value = 0.0;
    void take(double x, double part) { value += (value > 0.0 ? part : 1.0) * (x - value); }
    /// No more than twice as much as usual is believed at once.
    void take_capped(double x, double part) {
      take(value > 0.0 ? std::min(x, 2.0 * value) : x, part);
    }
  };

  void restart(double strength) {
    band_.restart(strength);
    walked_ = false;
    begin_walk(false);
  }

  template <class Sink>
  void follow(LogTime time, double strength, double dt, Sink&& sink) {
    const auto swing = band_.add(time, strength, dt, p_.pass_part * usual_swing_.value);
    const double x = band_.now();
    area_ += std::abs(x) * dt;
    area_s_ += dt;
    trough_ = std::min(trough_, x);
    if (swing) use(*swing, sink);
  }

  template <class Sink>
  void use(const Swing& s, Sink&& sink) {
    const double since = has_last_ ? to_seconds(s.time - last_) : 1e9;
    if (since > p_.longest_step_s)
      begin_walk(walked_ && to_seconds(s.time - walked_until_) < p_.resume_s);
    const double swing = s.crest_mps2 - s.trough_mps2;
    if (s.crest_mps2 < std::max(p_.least_crest, p_.crest_part * usual_crest_.value) ||
        swing < p_.swing_part * usual_swing_.value)
      return;
    const double usual_s = usual_s_.value;
    if (has_last_ && since < std::max(p_.refractory_s, p_.refractory_part * usual_s)) return;
    const bool late = has_last_ && usual_s > 0.0 && since > p_.hidden_from * usual_s;
    const bool hidden = late && walking_ && since < p_.hidden_to * usual_s;
    const double part = 1.0 / p_.memory_steps;
    usual_crest_.take_capped(s.crest_mps2, part);
    usual_swing_.take_capped(swing, part);
    if (has_last_) usual_s_.take(late ? 0.5 * since : since, part);
    const Step step{s.time,
                    has_last_ ? since : 0.0,
                    s.crest_mps2,
                    trough_,
                    area_s_ > 0.0 ? area_ / area_s_ : 0.0,
                    swing};
    trough_ = area_ = area_s_ = 0.0;
    last_ = s.time;
    has_last_ = true;
    announce(step, hidden, sink);
  }

  template <class Sink>
  void announce(Step step, bool hidden, Sink&& sink) {
    if (walking_) {
      if (hidden) {
        step.interval_s *= 0.5;
        Step before = step;
        before.time = step.time - from_seconds(step.interval_s);
        give(before, sink);
      }
      give(step, sink);
      return;
    }
    const auto first = onset_.add(step);
    for (const Step& s : first) give(s, sink);
    if (!first.empty()) walking_ = walked_ = true;
  }

  template <class Sink>
  void give(const Step& step, Sink&& sink) {
    walked_until_ = step.time;
    ++steps_;
    sink(step);
  }

  void begin_walk(bool resuming) {
    has_last_ = walking_ = false;
    onset_.clear(resuming);
    if (!resuming) usual_crest_ = usual_swing_ = usual_s_ = {};
    trough_ = area_ = area_s_ = 0.0;
  }

  StepParameters p_;
  SampleClock clock_{1.0};
  BandPassFilter band_;
  GaitStartDetector onset_;
  Usual usual_crest_, usual_swing_, usual_s_;
  double trough_ = 0.0, area_ = 0.0, area_s_ = 0.0;
  bool has_last_ = false, walking_ = false, walked_ = false;
  LogTime last_, walked_until_;
  std::uint64_t steps_ = 0;
};

}  // namespace wayfare
