#pragma once

// Swings of the specific force at walking frequencies, and the first steps of a walk.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <optional>
#include <span>

#include <wayfare/core/statistics.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/pedestrian/step.hpp>

namespace wayfare {

/// A crest and the preceding trough.
struct Swing {
  LogTime time;  ///< of the crest
  double crest_mps2 = 0.0, trough_mps2 = 0.0;
};

/// Filters a magnitude and detects its swings.
class BandPassFilter {
 public:
  explicit BandPassFilter(const StepParameters& p) : low_hz_(0.5 * p.low_hz), high_hz_(p.high_hz) {}

  void restart(double magnitude) {
    slow_ = {magnitude, magnitude};
    fast_.fill(0.0);
    now_ = 0.0;
    above_ = false;
  }

  /// The swing that ends with this reading, if any: the filtered value has fallen below −`pass`.
  [[nodiscard]] std::optional<Swing> add(LogTime time, double magnitude, double dt, double pass) {
    now_ = filter(magnitude, dt);
    if (above_) {
      if (now_ > swing_.crest_mps2) {
        swing_.crest_mps2 = now_;
        swing_.time = time;
      }
      if (now_ >= -pass) return std::nullopt;
      above_ = false;
      lowest_ = now_;
      return swing_;
    }
    lowest_ = std::min(lowest_, now_);
    if (now_ > pass) {
      above_ = true;
      swing_ = {time, now_, lowest_};
    }
    return std::nullopt;
  }

  [[nodiscard]] double now() const { return now_; }
  /// The time of the present crest, if its swing may still end.
  [[nodiscard]] std::optional<LogTime> crest() const {
    return above_ ? std::optional(swing_.time) : std::nullopt;
  }

 private:
  /// Removes the mean (gravity) and frequencies above those of steps; two poles each.
  [[nodiscard]] double filter(double magnitude, double dt) {
    set_step(dt);
    double x = magnitude;
    for (double& s : slow_) s += slow_gain_ * (x - s);
    x -= slow_[1];
    for (double& f : fast_) {
      f += fast_gain_ * (x - f);
      x = f;
    }
    return x;
  }

  void set_step(double dt) {
    if (dt == dt_) return;
    dt_ = dt;
    const auto gain = [dt](double hz) { return -std::expm1(-2.0 * std::numbers::pi * hz * dt); };
    slow_gain_ = gain(low_hz_);
    fast_gain_ = gain(high_hz_);
  }

  double low_hz_, high_hz_;
  double dt_ = 0.0, slow_gain_ = 0.0, fast_gain_ = 0.0;
  std::array<double, 2> slow_{}, fast_{};
  double now_ = 0.0, lowest_ = 0.0;
  bool above_ = false;
  Swing swing_;
};

class GaitStartDetector {
 public:
  explicit GaitStartDetector(const StepParameters& p)
      : swing_part_(p.onset_swing_part),
        interval_part_(p.onset_interval_part),
        min_steps_(p.least_steps),
        min_steps_to_resume_(p.resume_steps) {}

  /// `resuming`: shortly after a walk fewer steps suffice, of any regularity.
  void clear(bool resuming) {
    count_ = 0;
    resuming_ = resuming;
  }

  /// The first of the steps that are no walk yet; there is one after `add` that gave none.
  [[nodiscard]] LogTime first() const { return steps_[0].time; }

  /// The steps of the walk once it has started, else none.
  [[nodiscard]] std::span<const Step> add(const Step& step) {
    const auto needed = static_cast<std::size_t>(
        std::clamp(resuming_ ? min_steps_to_resume_ : min_steps_, 1, static_cast<int>(kMaxSteps)));
    steps_[count_++] = step;
    if (count_ < needed) return {};
    if (!resuming_) drop_irregular();
    if (count_ < needed) return {};
    complete_first();
    return {steps_.data(), count_};
  }

 private:
  static constexpr std::size_t kMaxSteps = 16;

  /// The walk begins after the last step that is too weak or too far from the next, as when a phone
  /// is put away before walking.
  void drop_irregular() {
    std::array<double, kMaxSteps> swings{}, intervals{};
    for (std::size_t i = 0; i < count_; ++i) {
      swings[i] = steps_[i].swing_mps2;
      intervals[i] = steps_[i].interval_s;
    }
    const double swing = upper_median_of(std::span(swings).first(count_));
    const double interval = upper_median_of(std::span(intervals).subspan(1, count_ - 1));
    std::size_t first = 0;
    for (std::size_t i = 0; i + 1 < count_; ++i) {
      const bool weak = steps_[i].swing_mps2 < swing_part_ * swing;
      const bool apart = steps_[i + 1].interval_s > interval_part_ * interval;
      if (weak || apart) first = i + 1;
    }
    const auto begin = steps_.begin();
    std::copy(begin + static_cast<std::ptrdiff_t>(first),
              begin + static_cast<std::ptrdiff_t>(count_), begin);
    count_ -= first;
  }
  /// The signal before the first step was no walking: its features are copied from the next.
  void complete_first() {
    if (count_ < 2) return;
    const Step first = steps_[0];
    steps_[0] = steps_[1];
    steps_[0].time = first.time;
    steps_[0].crest_mps2 = first.crest_mps2;
  }

  double swing_part_, interval_part_;
  int min_steps_, min_steps_to_resume_;
  std::array<Step, kMaxSteps> steps_{};
  std::size_t count_ = 0;
  bool resuming_ = false;
};

}  // namespace wayfare
