#pragma once

// Time offset of a unit by regressions that hold for any mounting, unit and sign: the rate of the
// course on the three gyros, the accelerations along and across it on the three accelerometers.

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "nav/check_drive/gnss_track.hpp"
#include "nav/check_drive/unit_means.hpp"

namespace wayfare::nav {

/// Weighted regression of a number on three others and a constant.
class Regression {
 public:
  void add(const Eigen::Vector3d& x, double y, double weight) {
    Eigen::Vector4d row;
    row << x, 1.0;
    normal_.noalias() += weight * row * row.transpose();
    right_ += weight * y * row;
    squares_ += weight * y * y, weights_ += weight;
    ++count_;
  }
  [[nodiscard]] int count() const { return count_; }
  /// Share of the variance that is explained.
  [[nodiscard]] double explained() const {
    const double mean = right_[3] / weights_;
    const double total = squares_ - mean * right_[3];
    const Eigen::Vector3d centre = normal_.col(3).head<3>() / weights_;
    Eigen::Matrix3d a = normal_.topLeftCorner<3, 3>() - weights_ * centre * centre.transpose();
    // A silent axis explains nothing.
    a.diagonal().array() += 1e-9 * a.trace() + 1e-30;
    const Eigen::Vector3d b = right_.head<3>() - right_[3] * centre;
    const double share = b.dot(a.ldlt().solve(b)) / total;
    return std::isfinite(share) ? std::clamp(share, 0.0, 0.9999) : 0.0;
  }

 private:
  Eigen::Matrix4d normal_ = Eigen::Matrix4d::Zero();
  Eigen::Vector4d right_ = Eigen::Vector4d::Zero();
  double squares_ = 0.0, weights_ = 0.0;
  int count_ = 0;
};

struct OffsetScore {
  double value = 0.0;  ///< logarithm of the likelihood ratio to no relation at all
  /// Shares of variance that the regressions explain, of the accelerations the larger.
  double course_explained = 0.0, force_explained = 0.0;
};

/// Zero without data.
inline OffsetScore offset_score(const GnssTrack& track, const UnitMeans& unit, double offset_s,
                                std::size_t stride) {
  constexpr double kLargestTurn_rad = 0.8;
  std::array<Regression, 3> fits;
  for (std::size_t i = 0; i < track.intervals.size(); i += stride) {
    const TrackInterval& k = track.intervals[i];
    const auto mean = unit.over(k.begin_s - offset_s, k.end_s - offset_s);
    if (!mean) continue;
    fits[0].add(mean->rate_radps, k.course_rate_radps,
                1.0 / (k.rate_sigma_radps * k.rate_sigma_radps));
    if (std::abs(k.course_rate_radps) * (k.end_s - k.begin_s) > kLargestTurn_rad) continue;
    const double weight = 1.0 / (k.force_sigma_mps2 * k.force_sigma_mps2);
    fits[1].add(mean->force_mps2, k.force_mps2.x(), weight);
    fits[2].add(mean->force_mps2, k.force_mps2.y(), weight);
  }
  OffsetScore score;
  for (const Regression& fit : fits) {
    if (fit.count() < 15) continue;
    const double independent =
        fit.count() * std::min(1.0, track.interval_spacing_s * static_cast<double>(stride));
    const double share = fit.explained();
    score.value -= 0.5 * independent * std::log(1.0 - share);
    double& explained = &fit == &fits[0] ? score.course_explained : score.force_explained;
    explained = std::max(explained, share);
  }
  return score;
}

struct TimeFit {
  double offset_s = 0.0;  ///< to add to the unit's times
  double sigma_s = 0.0;
  double score = 0.0;          ///< at the offset
  double score_at_zero = 0.0;  ///< at the configured time
  double next_score = 0.0;     ///< the best further than two seconds away
};

class TimeSearch {
 public:
  TimeSearch(const GnssTrack& track, const UnitMeans& unit) : track_(track), unit_(unit) {}

  /// Nothing if no offset fits.
  [[nodiscard]] std::optional<TimeFit> find() {
    if (track_.intervals.size() < 20 || unit_.empty()) return std::nullopt;
    stride_ = 1 + track_.intervals.size() / 1500;
    auto fit = best_of(-kNear_s, kNear_s, 0.1);
    if (!is_sure(fit)) {
      // Every offset with a minute of overlap.
      stride_ = 1 + track_.intervals.size() / 600;
      const double from = track_.intervals.front().begin_s - unit_.end_s() + 60.0;
      const double to = track_.intervals.back().end_s - unit_.begin_s() - 60.0;
      if (!(to > from) || to - from > 1e5) return std::nullopt;
      fit = best_of(from, to, std::max(0.25, (to - from) / 2e4));
      stride_ = 1 + track_.intervals.size() / 1500;
    }
    refine(fit);
    return is_sure(fit) ? std::optional(fit) : std::nullopt;
  }

 private:
  static constexpr double kNear_s = 40.0;

  [[nodiscard]] bool is_sure(const TimeFit& fit) const {
    // A walker turns long before the course does, and the accelerations are those of steps.
    const OffsetScore at = score(fit.offset_s);
    return fit.score > 20.0 && at.course_explained > 0.5 && at.force_explained > 0.35;
  }
  [[nodiscard]] OffsetScore score(double offset_s) const {
    return offset_score(track_, unit_, offset_s, stride_);
  }

  [[nodiscard]] TimeFit best_of(double from_s, double to_s, double step_s) const {
    TimeFit fit;
    fit.score_at_zero = score(0.0).value;
    std::vector<std::pair<double, double>> all;
    const int steps = static_cast<int>((to_s - from_s) / step_s);
    for (int i = 0; i <= steps; ++i) {
      const double at = from_s + i * step_s;
      all.emplace_back(at, score(at).value);
      if (all.back().second > fit.score) fit.offset_s = at, fit.score = all.back().second;
    }
    for (const auto& [at, value] : all)
      if (std::abs(at - fit.offset_s) > 2.0) fit.next_score = std::max(fit.next_score, value);
    return fit;
  }

  /// To 10 ms, then by the parabola through the scores beside the best.
  void refine(TimeFit& fit) const {
    const double centre = fit.offset_s;
    fit.score = score(centre).value;
    for (int i = -30; i <= 30; ++i) {
      const double at = centre + 0.01 * i, value = score(at).value;
      if (value > fit.score) fit.offset_s = at, fit.score = value;
    }
    constexpr double kArm_s = 0.05;
    const double before = score(fit.offset_s - kArm_s).value;
    const double after = score(fit.offset_s + kArm_s).value;
    const double bend = (2.0 * fit.score - before - after) / (kArm_s * kArm_s);
    if (!(bend > 0.0)) {
      fit.sigma_s = 1.0;
      return;
    }
    fit.offset_s += std::clamp(0.5 * (after - before) / kArm_s / bend, -kArm_s, kArm_s);
    fit.sigma_s = std::hypot(1.0 / std::sqrt(bend), 0.005);
  }

  const GnssTrack& track_;
  const UnitMeans& unit_;
  std::size_t stride_ = 1;
};

}  // namespace wayfare::nav
