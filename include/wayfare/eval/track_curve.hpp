#pragma once

// Tracks of positions in local axes: checked, interpolated, and aligned in space.

#include <algorithm>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>

#include <wayfare/core/contract.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/eval/table.hpp>

namespace wayfare::eval {

/// A position in local axes, z up.
struct TrackPoint {
  LogTime time;                                          ///< of the position
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  ///< m
};

using Track = std::vector<TrackPoint>;  ///< in order of time

/// Errors: fewer than two points; a position that is not finite; times that do not increase (with
/// the number of the point).
[[nodiscard]] inline Result<void> check(const Track& track) {
  const auto error = [&](std::size_t i, const std::string& what) {
    return Error{ErrorCode::invalid, "point " + std::to_string(i + 1) + ", at " +
                                         fixed(track[i].time.seconds(), 3) + " s, " + what};
  };
  for (std::size_t i = 0; i < track.size(); ++i) {
    if (!track[i].position_m.allFinite()) return error(i, "is not finite");
    if (i == 0 || track[i - 1].time < track[i].time) continue;
    return error(i, track[i].time < track[i - 1].time ? "is earlier than the point before it"
                                                      : "has the time of the point before it");
  }
  if (track.size() < 2) return Error{ErrorCode::invalid, "has fewer than two points"};
  return {};
}

/// The rigid motion T of space that minimises Σ ‖T pᵢ − qᵢ‖² (Umeyama 1991, without scale). Points
/// on a line leave the rotation about it free: the least one is taken. Identity without points;
/// both lists have the same length.
[[nodiscard]] inline SE3d rigid_alignment(std::span<const Eigen::Vector3d> from,
                                          std::span<const Eigen::Vector3d> to) {
  WAYFARE_EXPECTS(from.size() == to.size(), "as many points to align as references");
  if (from.empty()) return {};
  Eigen::Vector3d mean_from = Eigen::Vector3d::Zero(), mean_to = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < from.size(); ++i) mean_from += from[i], mean_to += to[i];
  mean_from /= static_cast<double>(from.size());
  mean_to /= static_cast<double>(to.size());
  Eigen::Matrix3d products = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < from.size(); ++i)
    products += (to[i] - mean_to) * (from[i] - mean_from).transpose();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(products, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d sign = Eigen::Vector3d::Ones();
  if ((svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0) sign.z() = -1.0;
  // On a line the least rotation is taken.
  const Eigen::Vector3d& sizes = svd.singularValues();
  if (sizes[1] <= 1e-9 * sizes[0] && sizes[0] > 0.0) {
    const SO3d least(
        Eigen::Quaterniond::FromTwoVectors(svd.matrixV().col(0), svd.matrixU().col(0)));
    return SE3d(mean_to - least * mean_from, least);
  }
  const SO3d rotation(
      Eigen::Matrix3d(svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose()));
  return SE3d(mean_to - rotation * mean_from, rotation);
}

/// A track at any time: cubic Hermite interpolation with the slopes of parabolas through three
/// points; nothing outside of it, and between points more than `max_gap` apart.
class TrackCurve {
 public:
  /// Of a checked track.
  TrackCurve(const Track& track, Duration max_gap) : track_(&track), max_gap_(max_gap) {
    slopes_.resize(track.size(), Eigen::Vector3d::Zero());
    for (std::size_t i = 0; i < track.size(); ++i) slopes_[i] = slope(i);
  }

  /// The position at `time`.
  [[nodiscard]] std::optional<Eigen::Vector3d> at(LogTime time) const {
    const Track& p = *track_;
    const auto after =
        std::upper_bound(p.begin(), p.end(), time,
                         [](LogTime t, const TrackPoint& point) { return t < point.time; });
    if (after == p.begin()) return std::nullopt;
    const auto i = static_cast<std::size_t>(after - p.begin()) - 1;
    if (p[i].time == time) return p[i].position_m;
    if (after == p.end() || gap_after(i)) return std::nullopt;
    const double h = to_seconds(after->time - p[i].time), k = to_seconds(time - p[i].time) / h;
    const double k2 = k * k, k3 = k2 * k;
    return (2.0 * k3 - 3.0 * k2 + 1.0) * p[i].position_m +
           (3.0 * k2 - 2.0 * k3) * after->position_m +
           h * ((k3 - 2.0 * k2 + k) * slopes_[i] + (k3 - k2) * slopes_[i + 1]);
  }
  /// The points.
  [[nodiscard]] const Track& track() const { return *track_; }

 private:
  [[nodiscard]] bool gap_after(std::size_t i) const {
    return i + 1 >= track_->size() || (*track_)[i + 1].time - (*track_)[i].time > max_gap_;
  }
  [[nodiscard]] Eigen::Vector3d step(std::size_t i) const {
    const TrackPoint &a = (*track_)[i], &b = (*track_)[i + 1];
    return (b.position_m - a.position_m) / to_seconds(b.time - a.time);
  }
  [[nodiscard]] Eigen::Vector3d slope(std::size_t i) const {
    const bool before = i > 0 && !gap_after(i - 1), after = !gap_after(i);
    if (!before && !after) return Eigen::Vector3d::Zero();
    if (!before) return gap_after(i + 1) ? step(i) : slope_at_end(i, i + 1);
    if (!after) return i < 2 || gap_after(i - 2) ? step(i - 1) : slope_at_end(i - 1, i - 2);
    const double h0 = interval(i - 1), h1 = interval(i);
    return (h1 * step(i - 1) + h0 * step(i)) / (h0 + h1);
  }
  /// Of the parabola through the points of the interval `near` at the end, and the one `next` to
  /// it.
  [[nodiscard]] Eigen::Vector3d slope_at_end(std::size_t near, std::size_t next) const {
    const double h0 = interval(near), h1 = interval(next);
    return step(near) - h0 / (h0 + h1) * (step(next) - step(near));
  }
  [[nodiscard]] double interval(std::size_t i) const {
    return to_seconds((*track_)[i + 1].time - (*track_)[i].time);
  }

  const Track* track_;
  Duration max_gap_;
  std::vector<Eigen::Vector3d> slopes_;
};

}  // namespace wayfare::eval
