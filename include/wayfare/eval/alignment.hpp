#pragma once

#include <cmath>
#include <cstddef>
#include <span>

#include <Eigen/Core>

#include <wayfare/core/contract.hpp>
#include <wayfare/core/se2.hpp>

namespace wayfare::eval {

enum class Alignment {
  none,   ///< both trajectories are in the same frame already
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

}  // namespace wayfare::eval
