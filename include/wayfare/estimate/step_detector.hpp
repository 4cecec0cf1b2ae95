#pragma once

// Steps from the strength of the specific force, wherever on the body it is measured.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>

#include <Eigen/Core>

#include <wayfare/core/time.hpp>
#include <wayfare/estimate/attitude.hpp>
#include <wayfare/estimate/sample_clock.hpp>

namespace wayfare {

/// How steps are told from other motion. Found on hands, pockets, arms, necks and bags alike.
struct StepParameters {
  /// The strength is kept between these frequencies, Hz: walking has one to three steps a second.
  double low_hz = 0.8;
  double high_hz = 3.0;
  /// A step's crest is at least this high, m/s², and this part of the crests of late.
  double least_crest = 0.3;
  double crest_part = 0.2;
  double crest_memory_steps = 15.0;
  /// No two steps are nearer than this, s, nor nearer than this part of the time between steps of
  /// late.
  double refractory_s = 0.25;
  double refractory_part = 0.5;
  /// Steps further apart than this, s, are not of one walk; so many in a row make one.
  double longest_step_s = 1.0;
  int least_steps = 8;
  /// Of these a step weaker than this part of their median, or further from the next than this
  /// multiple of theirs, is not of the walk.
  double onset_crest_part = 0.2;
  double onset_interval_part = 1.6;
  /// Who walked less than this ago, s, walks again after so many steps.
  double resume_s = 10.0;
  int resume_steps = 3;
  double force_range = 156.0;  ///< a component from here on is cut there, m/s²
};

/// One step, known shortly after its crest.
struct Step {
  LogTime time;          ///< of the crest
  double interval_s;     ///< since the step before; of the first in a walk, to the next
  double crest_mps2;     ///< of the band-limited strength
  double trough_mps2;    ///< lowest since the step before
  double mean_abs_mps2;  ///< mean of the band-limited strength without sign
};

/// Causal and without memory beyond itself. A step is announced a fifth of a second after its
/// crest, the first ones of a walk together once there are enough of them.
class StepDetector {
 public:
  explicit StepDetector(const StepParameters& parameters = {}) : p_(parameters) {}

  /// Hands the steps that are now known to `sink(const Step&)`.
  template <class Sink>
  Intake add(LogTime time, const Eigen::Vector3d& force_mps2, Sink&& sink) {
    if (!force_mps2.allFinite()) return Intake::missing;
    const auto verdict = clock_.check(time);
    if (verdict == SampleClock::Verdict::late) return Intake::late;
    const bool saturated = force_mps2.cwiseAbs().maxCoeff() >= p_.force_range;
    const double strength = force_mps2.cwiseMin(p_.force_range).cwiseMax(-p_.force_range).norm();
    const double dt = clock_.step_s();
    if (verdict == SampleClock::Verdict::first || dt > 0.5) {
      restart(strength);
    } else {
      follow(time, filter(strength, dt), dt, sink);
    }
    return saturated ? Intake::saturated : Intake::used;
  }

  [[nodiscard]] std::uint64_t steps() const { return steps_; }
  /// The band-limited strength, m/s².
  [[nodiscard]] double band() const { return now_; }

 private:
  static constexpr std::size_t kMostPending = 16;

  void restart(double strength) {
    slow_ = {strength, strength};
    quick_.fill(0.0);
    now_ = 0.0;
    above_ = false;
    walked_ = false;
    begin_walk(false);
  }

  [[nodiscard]] double filter(double strength, double dt) {
    const auto part = [dt](double hz) { return -std::expm1(-6.283185307179586 * hz * dt); };
    // The mean, which is near gravity, and what is too quick for steps; two poles each.
    double x = strength;
    for (double& s : slow_) {
      s += part(p_.low_hz * 0.5) * (x - s);
    }
    x -= slow_[1];
    for (double& q : quick_) {
      q += part(p_.high_hz) * (x - q);
      x = q;
    }
    return x;
  }

  template <class Sink>
  void follow(LogTime time, double x, double dt, Sink&& sink) {
    now_ = x;
    area_ += std::abs(x) * dt;
    area_s_ += dt;
    trough_ = std::min(trough_, x);
    if (x > 0.0) {
      if (!above_ || x > crest_) {
        crest_ = above_ ? std::max(crest_, x) : x;
        crest_time_ = time;
      }
      above_ = true;
    } else if (above_) {
      above_ = false;
      use_crest(sink);
    }
  }

  template <class Sink>
  void use_crest(Sink&& sink) {
    const double since = has_last_ ? to_seconds(crest_time_ - last_) : 1e9;
    if (since > p_.longest_step_s)
      begin_walk(walked_ && to_seconds(crest_time_ - walked_until_) < p_.resume_s);
    const double threshold = std::max(p_.least_crest, p_.crest_part * usual_crest_);
    if (crest_ < threshold) return;
    const double refractory = std::max(p_.refractory_s, p_.refractory_part * usual_s_);
    if (has_last_ && since < refractory) return;
    const bool first = !has_last_;
    const double memory = 1.0 / p_.crest_memory_steps;
    const double capped = usual_crest_ > 0.0 ? std::min(crest_, 2.0 * usual_crest_) : crest_;
    usual_crest_ += (usual_crest_ > 0.0 ? memory : 1.0) * (capped - usual_crest_);
    if (!first) usual_s_ += (usual_s_ > 0.0 ? memory : 1.0) * (since - usual_s_);
    const Step step{crest_time_, first ? 0.0 : since, crest_, trough_,
                    area_s_ > 0.0 ? area_ / area_s_ : 0.0};
    trough_ = area_ = area_s_ = 0.0;
    last_ = crest_time_;
    has_last_ = true;
    announce(step, sink);
  }

  template <class Sink>
  void announce(const Step& step, Sink&& sink) {
    if (walking_) {
      walked_until_ = step.time;
      ++steps_;
      sink(step);
      return;
    }
    const auto needed = static_cast<std::size_t>(std::clamp(
        resuming_ ? p_.resume_steps : p_.least_steps, 1, static_cast<int>(kMostPending)));
    pending_[pending_count_++] = step;
    if (pending_count_ < needed) return;
    if (!resuming_) drop_irregular();
    if (pending_count_ < needed) return;
    walking_ = walked_ = true;
    walked_until_ = step.time;
    if (pending_count_ > 1) {
      // What came before a walk's first step was no walking: it is taken for one like the next.
      const LogTime first = pending_[0].time;
      const double crest = pending_[0].crest_mps2;
      pending_[0] = pending_[1];
      pending_[0].time = first;
      pending_[0].crest_mps2 = crest;
    }
    for (std::size_t i = 0; i < pending_count_; ++i) {
      ++steps_;
      sink(static_cast<const Step&>(pending_[i]));
    }
    pending_count_ = 0;
  }

  /// A walk begins after the last of the pending steps that is too weak or too far from the next to
  /// be of it: a phone is put away before one walks.
  void drop_irregular() {
    std::array<double, kMostPending> crests{}, intervals{};
    for (std::size_t i = 0; i < pending_count_; ++i) {
      crests[i] = pending_[i].crest_mps2;
      intervals[i] = pending_[i].interval_s;
    }
    const double crest = median(crests.begin(), pending_count_);
    const double interval = median(intervals.begin() + 1, pending_count_ - 1);
    std::size_t first = 0;
    for (std::size_t i = 0; i + 1 < pending_count_; ++i) {
      const bool weak = pending_[i].crest_mps2 < p_.onset_crest_part * crest;
      const bool apart = pending_[i + 1].interval_s > p_.onset_interval_part * interval;
      if (weak || apart) first = i + 1;
    }
    std::copy(pending_.begin() + static_cast<std::ptrdiff_t>(first),
              pending_.begin() + static_cast<std::ptrdiff_t>(pending_count_), pending_.begin());
    pending_count_ -= first;
  }
  template <class Iterator>
  [[nodiscard]] static double median(Iterator begin, std::size_t n) {
    if (n == 0) return 0.0;
    const auto middle = begin + static_cast<std::ptrdiff_t>(n / 2);
    std::nth_element(begin, middle, begin + static_cast<std::ptrdiff_t>(n));
    return *middle;
  }

  void begin_walk(bool resuming) {
    has_last_ = walking_ = false;
    pending_count_ = 0;
    resuming_ = resuming;
    if (!resuming) usual_crest_ = usual_s_ = 0.0;
    trough_ = area_ = area_s_ = 0.0;
  }

  StepParameters p_;
  SampleClock clock_{1.0};
  std::array<double, 2> slow_{};
  std::array<double, 2> quick_{};
  double now_ = 0.0, crest_ = 0.0, trough_ = 0.0, area_ = 0.0, area_s_ = 0.0;
  double usual_crest_ = 0.0, usual_s_ = 0.0;
  bool above_ = false, has_last_ = false, walking_ = false;
  bool walked_ = false, resuming_ = false;
  LogTime crest_time_, last_, walked_until_;
  std::array<Step, kMostPending> pending_{};
  std::size_t pending_count_ = 0;
  std::uint64_t steps_ = 0;
};

}  // namespace wayfare
