#pragma once

// The swings of the specific force's strength: what of it has the frequencies of walking.

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <wayfare/core/time.hpp>
#include <wayfare/pedestrian/step.hpp>

namespace wayfare {

/// A crest and the trough before it.
struct Swing {
  LogTime time;  ///< of the crest
  double crest_mps2 = 0.0, trough_mps2 = 0.0;
};

/// Band-limits a strength and finds its swings.
class BandPassFilter {
 public:
  explicit BandPassFilter(const StepParameters& p) : low_hz_(0.5 * p.low_hz), high_hz_(p.high_hz) {}

  void restart(double strength) {
    slow_ = {strength, strength};
    quick_.fill(0.0);
    now_ = 0.0;
    above_ = false;
  }

  /// The swing that ends with this reading, where one does: the strength has passed its mean by
  /// `pass`.
  [[nodiscard]] std::optional<Swing> add(LogTime time, double strength, double dt, double pass) {
    now_ = filter(strength, dt);
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
  /// Without the mean, which is near gravity, and what is too quick for steps; two poles each.
  [[nodiscard]] double filter(double strength, double dt) {
    const auto part = [dt](double hz) { return -std::expm1(-6.283185307179586 * hz * dt); };
    double x = strength;
    for (double& s : slow_) s += part(low_hz_) * (x - s);
    x -= slow_[1];
    for (double& q : quick_) {
      q += part(high_hz_) * (x - q);
      x = q;
    }
    return x;
  }

  double low_hz_, high_hz_;
  std::array<double, 2> slow_{}, quick_{};
  double now_ = 0.0, lowest_ = 0.0;
  bool above_ = false;
  Swing swing_;
};

}  // namespace wayfare
