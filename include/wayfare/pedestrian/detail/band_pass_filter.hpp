#pragma once

// Band-pass filter of the specific force's magnitude at walking frequencies, with its swings.

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

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

 private:
  /// Removes the mean (gravity) and frequencies above those of steps; two poles each.
  [[nodiscard]] double filter(double magnitude, double dt) {
    const auto gain = [dt](double hz) { return -std::expm1(-2.0 * std::numbers::pi * hz * dt); };
    double x = magnitude;
    for (double& s : slow_) s += gain(low_hz_) * (x - s);
    x -= slow_[1];
    for (double& f : fast_) {
      f += gain(high_hz_) * (x - f);
      x = f;
    }
    return x;
  }

  double low_hz_, high_hz_;
  std::array<double, 2> slow_{}, fast_{};
  double now_ = 0.0, lowest_ = 0.0;
  bool above_ = false;
  Swing swing_;
};

}  // namespace wayfare
