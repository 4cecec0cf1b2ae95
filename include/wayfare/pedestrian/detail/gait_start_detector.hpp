#pragma once

// The first steps of a walk, kept until there are enough of them.

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

#include <wayfare/pedestrian/step.hpp>

namespace wayfare {

class GaitStartDetector {
 public:
  explicit GaitStartDetector(const StepParameters& p)
      : swing_part_(p.onset_swing_part),
        interval_part_(p.onset_interval_part),
        least_(p.least_steps),
        least_to_resume_(p.resume_steps) {}

  /// `resuming`: who walked a moment ago needs fewer steps, and any will do.
  void clear(bool resuming) {
    count_ = 0;
    resuming_ = resuming;
  }

  /// The steps of the walk that began, or none as long as none did.
  [[nodiscard]] std::span<const Step> add(const Step& step) {
    const auto needed = static_cast<std::size_t>(
        std::clamp(resuming_ ? least_to_resume_ : least_, 1, static_cast<int>(kMost)));
    steps_[count_++] = step;
    if (count_ < needed) return {};
    if (!resuming_) drop_irregular();
    if (count_ < needed) return {};
    complete_first();
    return {steps_.data(), count_};
  }

 private:
  static constexpr std::size_t kMost = 16;

  /// A walk begins after the last of the steps that is too weak or too far from the next to be of
  /// it: a phone is put away before one walks.
  void drop_irregular() {
    std::array<double, kMost> swings{}, intervals{};
    for (std::size_t i = 0; i < count_; ++i) {
      swings[i] = steps_[i].swing_mps2;
      intervals[i] = steps_[i].interval_s;
    }
    const double swing = median(swings.begin(), count_);
    const double interval = median(intervals.begin() + 1, count_ - 1);
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
  /// What came before a walk's first step was no walking: it is taken for one like the next.
  void complete_first() {
    if (count_ < 2) return;
    const Step first = steps_[0];
    steps_[0] = steps_[1];
    steps_[0].time = first.time;
    steps_[0].crest_mps2 = first.crest_mps2;
  }

  template <class Iterator>
  [[nodiscard]] static double median(Iterator begin, std::size_t n) {
    if (n == 0) return 0.0;
    const auto middle = begin + static_cast<std::ptrdiff_t>(n / 2);
    std::nth_element(begin, middle, begin + static_cast<std::ptrdiff_t>(n));
    return *middle;
  }

  double swing_part_, interval_part_;
  int least_, least_to_resume_;
  std::array<Step, kMost> steps_{};
  std::size_t count_ = 0;
  bool resuming_ = false;
};

}  // namespace wayfare
