#pragma once

// Absolute and relative trajectory error (Sturm, Engelhard, Endres, Burgard, Cremers, "A benchmark
// for the evaluation of RGB-D SLAM systems", IROS 2012), and the error per axis.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/contract.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/core/statistics.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/sensors/trajectory.hpp>

namespace wayfare::eval {

/// Attitude error by Laidig et al. 2021 ("BROAD", section 4): the total angle of the error
/// quaternion in world axes with z up (or down), its part about the vertical, and the inclination
/// error.
struct AttitudeError {
  Angle total;        ///< angle of the error quaternion
  Angle heading;      ///< its part about the vertical
  Angle inclination;  ///< its part about a horizontal axis
};

/// Of an estimate against the truth, both body to the same world.
[[nodiscard]] inline AttitudeError attitude_error(const SO3d& q_world_body, const SO3d& truth) {
  const auto q = (q_world_body * truth.inverse()).quaternion();
  // Angles from both sine and cosine, since an arc cosine near one is accurate to 1e-8 only.
  const double level = std::hypot(q.x(), q.y());
  return {Angle::radians(2.0 * std::atan2(q.vec().norm(), std::abs(q.w()))),
          Angle::radians(2.0 * std::atan2(std::abs(q.z()), std::abs(q.w()))),
          Angle::radians(2.0 * std::atan2(level, std::hypot(q.w(), q.z())))};
}

/// Root mean squares of attitude errors.
class AttitudeRmse {
 public:
  /// Takes one error.
  void add(const AttitudeError& e) {
    total_ += e.total.radians() * e.total.radians();
    heading_ += e.heading.radians() * e.heading.radians();
    inclination_ += e.inclination.radians() * e.inclination.radians();
    ++count_;
  }
  /// Number of errors.
  [[nodiscard]] std::size_t count() const { return count_; }
  /// NaN without errors.
  [[nodiscard]] AttitudeError value() const {
    const auto root = [&](double sum) {
      return Angle::radians(std::sqrt(sum / static_cast<double>(count_)));
    };
    return {root(total_), root(heading_), root(inclination_)};
  }

 private:
  double total_ = 0.0, heading_ = 0.0, inclination_ = 0.0;
  std::size_t count_ = 0;
};

/// How an estimate is brought into the reference's frame.
enum class Alignment {
  none,   ///< both trajectories are in the same frame already
  start,  ///< rigid transformation of the estimate that starts it at the reference's pose
  rigid,  ///< rigid transformation of the estimate that fits the reference best
};

/// The rigid motion T that minimises Σ ‖T pᵢ − qᵢ‖²: Umeyama 1991 without scale. In the plane the
/// rotation has a closed form: tan θ = Σ (pᵢ − p̄) × (qᵢ − q̄) / Σ (pᵢ − p̄) · (qᵢ − q̄), and t =
/// q̄ − R p̄. If the points do not determine the rotation (one point, or all equal) it is the
/// identity. Both lists have the same length.
[[nodiscard]] inline SE2d rigid_alignment(std::span<const Eigen::Vector2d> from,
                                          std::span<const Eigen::Vector2d> to) {
  WAYFARE_EXPECTS(from.size() == to.size(), "as many points to align as references");
  if (from.empty()) return {};
  Eigen::Vector2d mean_from = Eigen::Vector2d::Zero(), mean_to = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < from.size(); ++i) mean_from += from[i], mean_to += to[i];
  mean_from /= static_cast<double>(from.size());
  mean_to /= static_cast<double>(to.size());
  double dot = 0.0, cross = 0.0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const Eigen::Vector2d p = from[i] - mean_from, q = to[i] - mean_to;
    dot += p.dot(q);
    cross += p.x() * q.y() - p.y() * q.x();
  }
  const SO2d rotation(Angle::radians(std::atan2(cross, dot)));
  return SE2d(Eigen::Vector2d(mean_to - rotation * mean_from), rotation);
}

/// Length of the trajectory.
[[nodiscard]] inline double path_length_m(std::span<const StampedPose> trajectory) {
  double length = 0.0;
  for (std::size_t i = 1; i < trajectory.size(); ++i) {
    length += (trajectory[i].T_map_base.raw().translation() -
               trajectory[i - 1].T_map_base.raw().translation())
                  .norm();
  }
  return length;
}

/// An estimated pose and the true one at the same time.
struct PosePair {
  LogTime time;    ///< of both
  SE2d estimate;   ///< estimated pose
  SE2d reference;  ///< true pose
};

/// Every sample of `estimate` with the reference interpolated at its time; samples outside the
/// reference or in its gaps are omitted.
[[nodiscard]] inline std::vector<PosePair> associate(std::span<const StampedPose> estimate,
                                                     std::span<const StampedPose> reference,
                                                     const GapLimit& limit = {}) {
  std::vector<PosePair> pairs;
  for (const StampedPose& sample : estimate) {
    if (const std::optional<SE2d> truth = pose_at(reference, sample.time, limit))
      pairs.push_back({sample.time, sample.T_map_base.raw(), *truth});
  }
  return pairs;
}

/// Absolute trajectory error (ATE) and its parts; NaN without pairs.
struct AbsoluteError {
  Summary translation_m;  ///< distances from the true positions, m
  Summary heading_deg;    ///< absolute value
  /// Root mean square of the error along x, m; the axes by AbsoluteOptions::estimate_axes.
  double rmse_x_m = std::numeric_limits<double>::quiet_NaN();
  /// The same along y.
  double rmse_y_m = std::numeric_limits<double>::quiet_NaN();
  /// Root mean square of the heading error, degrees.
  double rmse_heading_deg = std::numeric_limits<double>::quiet_NaN();
  /// Of the reference, between the first and the last pair.
  double path_length_m = 0.0;
  /// RMSE of the translation relative to the path length, percent.
  double percent_of_path = std::numeric_limits<double>::quiet_NaN();
  double end_m = std::numeric_limits<double>::quiet_NaN();        ///< translation at the last pair
  double end_percent = std::numeric_limits<double>::quiet_NaN();  ///< of the path length
  SE2d alignment;                      ///< applied to the estimate from the left
  std::size_t unmatched = 0;           ///< estimated poses without a reference
  std::vector<LogTime> times;          ///< of the pairs
  std::vector<double> translations_m;  ///< at `times`, for plots
};

namespace detail {

inline SE2d alignment_of(std::span<const PosePair> pairs, Alignment how) {
  if (how == Alignment::none || pairs.empty()) return {};
  if (how == Alignment::start) return pairs.front().reference * pairs.front().estimate.inverse();
  std::vector<Eigen::Vector2d> from, to;
  for (const PosePair& pair : pairs) {
    from.push_back(pair.estimate.translation());
    to.push_back(pair.reference.translation());
  }
  return rigid_alignment(from, to);
}

}  // namespace detail

/// Alignment and axes of the absolute error.
struct AbsoluteOptions {
  Alignment alignment = Alignment::rigid;  ///< applied before the errors are taken
  GapLimit gaps = {};                      ///< where the reference is not interpolated
  /// Errors in x and y along the axes of the estimate's frame instead of the reference's.
  bool estimate_axes = false;
};

/// Of pairs in order of time.
[[nodiscard]] inline AbsoluteError absolute_error(std::span<const PosePair> pairs,
                                                  const AbsoluteOptions& options = {}) {
  AbsoluteError result;
  result.alignment = detail::alignment_of(pairs, options.alignment);
  const SO2d to_axes = options.estimate_axes ? result.alignment.rotation().inverse() : SO2d();
  std::vector<double> x, y, headings;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const SE2d aligned = result.alignment * pairs[i].estimate;
    Eigen::Vector2d d = aligned.translation() - pairs[i].reference.translation();
    const SO2d rotation = pairs[i].reference.rotation().inverse() * aligned.rotation();
    result.times.push_back(pairs[i].time);
    result.translations_m.push_back(d.norm());
    if (options.estimate_axes) d = to_axes * d;
    x.push_back(d.x());
    y.push_back(d.y());
    headings.push_back(std::abs(rotation.angle().degrees()));
    if (i > 0) {
      result.path_length_m +=
          (pairs[i].reference.translation() - pairs[i - 1].reference.translation()).norm();
    }
  }
  result.translation_m = summarise(result.translations_m);
  result.heading_deg = summarise(headings);
  result.rmse_x_m = summarise(x).rmse;
  result.rmse_y_m = summarise(y).rmse;
  result.rmse_heading_deg = result.heading_deg.rmse;
  if (!pairs.empty()) result.end_m = result.translations_m.back();
  if (result.path_length_m > 0.0) {
    result.percent_of_path = 100.0 * result.translation_m.rmse / result.path_length_m;
    result.end_percent = 100.0 * result.end_m / result.path_length_m;
  }
  return result;
}

/// Both trajectories are in order of time.
[[nodiscard]] inline AbsoluteError absolute_error(std::span<const StampedPose> estimate,
                                                  std::span<const StampedPose> reference,
                                                  const AbsoluteOptions& options = {}) {
  const std::vector<PosePair> pairs = associate(estimate, reference, options.gaps);
  AbsoluteError result = absolute_error(pairs, options);
  result.unmatched = estimate.size() - pairs.size();
  return result;
}

/// Separation of the two poses of a relative error.
struct Span {
  /// What `length` measures.
  enum class Kind {
    time,      ///< s
    distance,  ///< m along the reference
  };

  Kind kind = Kind::time;  ///< of `length`
  double length = 1.0;     ///< seconds, or metres along the reference

  /// A separation in time.
  [[nodiscard]] static Span seconds(double s) { return {Kind::time, s}; }
  /// A separation along the reference's path.
  [[nodiscard]] static Span metres(double m) { return {Kind::distance, m}; }
};

/// Relative pose error (RPE) over a span.
struct RelativeError {
  Summary translation_m;  ///< of the relative pose, m
  Summary heading_deg;    ///< absolute value
};

/// From every pair to the first one at least a span later: (x̂ᵢ⁻¹ x̂ⱼ) against (xᵢ⁻¹ xⱼ).
[[nodiscard]] inline RelativeError relative_error(std::span<const PosePair> pairs, Span span) {
  std::vector<double> at(pairs.size(), 0.0), translations, headings;
  for (std::size_t i = 1; i < pairs.size(); ++i) {
    const Eigen::Vector2d step =
        pairs[i].reference.translation() - pairs[i - 1].reference.translation();
    at[i] = span.kind == Span::Kind::time ? to_seconds(pairs[i].time - pairs[0].time)
                                          : at[i - 1] + step.norm();
  }
  // Rounding must not make a span longer than the sum of its steps.
  const double length = span.length * (1.0 - 1e-12);
  std::size_t j = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    j = std::max(j, i + 1);
    while (j < pairs.size() && at[j] - at[i] < length) ++j;
    if (j >= pairs.size()) break;
    const SE2d truth = pairs[i].reference.inverse() * pairs[j].reference;
    const SE2d error = truth.inverse() * (pairs[i].estimate.inverse() * pairs[j].estimate);
    translations.push_back(error.translation().norm());
    headings.push_back(std::abs(error.heading().degrees()));
  }
  return {summarise(translations), summarise(headings)};
}

}  // namespace wayfare::eval
