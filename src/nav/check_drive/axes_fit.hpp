#pragma once

// Axes of a unit: the response of its accelerometers to accelerations along and across the course
// and to gravity gives mounting and handedness, and the tilt by them the gains of the gyros.

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Geometry>

#include <wayfare/core/se3.hpp>

#include "nav/check_drive/gnss_track.hpp"
#include "nav/check_drive/unit_means.hpp"

namespace wayfare::nav {

/// Specific force in the unit's axes = forward · a_forward + right · a_right + constant.
struct ForceFit {
  Eigen::Vector3d forward = Eigen::Vector3d::Zero(), right = Eigen::Vector3d::Zero();
  Eigen::Vector3d constant = Eigen::Vector3d::Zero();
  double forward_sigma = 0.0, right_sigma = 0.0;  ///< of each component
  int count = 0;
};

/// An interval with the unit's means over it.
struct Pair {
  TrackInterval track;
  UnitMean unit;
};

inline std::vector<Pair> pairs_at(const GnssTrack& track, const UnitMeans& unit, double offset_s) {
  std::vector<Pair> result;
  for (const TrackInterval& k : track.intervals)
    if (const auto mean = unit.over(k.begin_s - offset_s, k.end_s - offset_s))
      result.push_back({k, *mean});
  return result;
}

inline std::optional<ForceFit> fit_force(const std::vector<Pair>& pairs, double spacing_s) {
  constexpr double kLargestTurn_rad = 0.8;
  ForceFit fit;
  Eigen::Matrix3d answer = Eigen::Matrix3d::Zero();
  double scale = 1e9;
  for (int round = 0; round < 4; ++round) {
    Eigen::Matrix3d a = Eigen::Matrix3d::Zero(), b = Eigen::Matrix3d::Zero();
    std::vector<double> residuals;
    fit.count = 0;
    for (const Pair& p : pairs) {
      const double turn = std::abs(p.track.course_rate_radps) * (p.track.end_s - p.track.begin_s);
      if (turn > kLargestTurn_rad) continue;
      const Eigen::Vector3d row(p.track.force_mps2.x(), p.track.force_mps2.y(), 1.0);
      const double r = (p.unit.force_mps2 - answer.transpose() * row).norm();
      residuals.push_back(r);
      const double weight = std::min(1.0, scale / std::max(r, 1e-12)) /
                            (p.track.force_sigma_mps2 * p.track.force_sigma_mps2);
      a += weight * row * row.transpose();
      b += weight * row * p.unit.force_mps2.transpose();
      ++fit.count;
    }
    if (fit.count < 20) return std::nullopt;
    const Eigen::LDLT<Eigen::Matrix3d> solver(a);
    answer = solver.solve(b);
    if (!answer.allFinite()) return std::nullopt;
    const double typical = upper_median_of(residuals);
    scale = 2.5 * typical;
    // Of each component; the weights are relative to the mean variance of the intervals.
    const Eigen::Matrix3d inverse = solver.solve(Eigen::Matrix3d::Identity());
    const double mean_weight = a(2, 2) / fit.count;
    const double sigma = typical * std::sqrt(mean_weight / std::max(spacing_s, 0.05));
    fit.forward_sigma = sigma * std::sqrt(std::max(inverse(0, 0), 0.0));
    fit.right_sigma = sigma * std::sqrt(std::max(inverse(1, 1), 0.0));
  }
  fit.forward = answer.row(0), fit.right = answer.row(1), fit.constant = answer.row(2);
  return fit;
}

/// Heading of the mounting by the accelerations, for axes of either hand.
struct MountingFit {
  SO3d q_body_imu;
  double heading_sigma_rad = 10.0;
  double response = 0.0;  ///< to the accelerations of a right-handed unit, σ
  bool mirrored = false;  ///< surely left-handed
};

/// `sign` of each axis is applied to the readings.
inline MountingFit fit_mounting(const ForceFit& fit, const Eigen::Vector3d& sign) {
  const auto flip = [&sign](const Eigen::Vector3d& v) -> Eigen::Vector3d {
    return v.cwiseProduct(sign);
  };
  const double gravity = std::max(fit.constant.norm(), 1e-9);
  const Eigen::Vector3d down = -flip(fit.constant) / gravity;
  const Eigen::Vector3d e1 = down.unitOrthogonal(), e2 = down.cross(e1);
  const Eigen::Vector3d f = flip(fit.forward), r = flip(fit.right);
  const Eigen::Vector2d forward(f.dot(e1), f.dot(e2)), right(r.dot(e1), r.dot(e2));
  // Right, turned back by a quarter, is forward.
  const Eigen::Vector2d as_proper(right.y(), -right.x());
  const double wf = 1.0 / std::max(fit.forward_sigma * fit.forward_sigma, 1e-18);
  const double wr = 1.0 / std::max(fit.right_sigma * fit.right_sigma, 1e-18);
  const Eigen::Vector2d sum = (wf * forward + wr * as_proper) / (wf + wr);
  const double sigma = 1.0 / std::sqrt(wf + wr);
  MountingFit m;
  m.response = sum.norm() / sigma;
  // Forward and the turned right are opposite instead of equal, by many standard deviations.
  const double along = forward.dot(as_proper);
  m.mirrored =
      along < -0.5 * forward.norm() * right.norm() && -4.0 * along > 60.0 * (1.0 / wf + 1.0 / wr);
  m.heading_sigma_rad = std::hypot(sigma / std::max(sum.norm(), 1e-12), 0.005);
  const Eigen::Vector3d x = (sum.x() * e1 + sum.y() * e2).normalized();
  Eigen::Matrix3d body;
  body.row(0) = x, body.row(1) = down.cross(x), body.row(2) = down;
  if (body.allFinite()) m.q_body_imu = SO3d(body);
  return m;
}

/// Factors from readings to true rates, by axis.
struct GyroFit {
  Eigen::Vector3d gain = Eigen::Vector3d::Ones();
  Eigen::Vector3d sigma = Eigen::Vector3d::Constant(1e9);

  /// The size of all gains, which is that of a unit, and its standard deviation.
  [[nodiscard]] std::pair<double, double> common() const {
    const Eigen::Vector3d weight = sigma.cwiseAbs2().cwiseInverse();
    return {weight.dot(gain.cwiseAbs()) / weight.sum(), 1.0 / std::sqrt(weight.sum())};
  }
};

/// By the rate of the course about the vertical, and by the changes of gravity's direction between
/// intervals, dg/dt = g × ω. `force_sign` makes the accelerometers right-handed.
inline GyroFit fit_gyros(const std::vector<Pair>& pairs, const UnitMeans& unit, double offset_s,
                         const MountingFit& mounting, const Eigen::Vector3d& force_sign,
                         double force_scale, double spacing_s) {
  constexpr double kSpan_s = 4.0;
  using Vector4d = Eigen::Vector4d;
  const Eigen::Matrix3d unit_body = mounting.q_body_imu.inverse().matrix();
  const Eigen::Vector3d forward = unit_body.col(0), right = unit_body.col(1),
                        down = unit_body.col(2);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Pair& p : pairs) mean += p.unit.rate_radps / static_cast<double>(pairs.size());
  const auto gravity_of = [&](const Pair& p) -> Eigen::Vector3d {
    return force_scale * p.unit.force_mps2.cwiseProduct(force_sign) -
           p.track.acceleration_mps2.x() * forward - p.track.acceleration_mps2.y() * right;
  };
  struct Row {
    Vector4d x;
    double y, sigma;
    bool course;
  };
  std::vector<Row> rows;
  std::size_t k = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Pair& a = pairs[i];
    const Eigen::Vector3d rate = a.unit.rate_radps - mean;
    Vector4d course;
    course << down.cwiseProduct(rate), 1.0;
    rows.push_back({course, a.track.course_rate_radps, a.track.rate_sigma_radps, true});
    // Long enough for a tilt of the road or in a bend to build up.
    k = std::max(k, i + 1);
    while (k < pairs.size() && pairs[k].track.begin_s < a.track.begin_s + kSpan_s) ++k;
    if (k == pairs.size()) continue;
    const Pair& b = pairs[k];
    const double from = 0.5 * (a.track.begin_s + a.track.end_s);
    const double to = 0.5 * (b.track.begin_s + b.track.end_s);
    if (to - from > 2.0 * kSpan_s) continue;
    const auto between = unit.over(from - offset_s, to - offset_s);
    if (!between) continue;
    const Eigen::Vector3d ga = gravity_of(a), gb = gravity_of(b);
    const Eigen::Vector3d turn = (to - from) * (between->rate_radps - mean);
    const double sigma = 1.5 * std::hypot(a.track.force_sigma_mps2, b.track.force_sigma_mps2);
    if ((gb - ga).norm() > 4.0 + 5.0 * sigma) continue;
    for (const Eigen::Vector3d& axis : {forward, right}) {
      // axis · (g × e_j θ_j) = (axis × g)_j θ_j
      Vector4d x;
      x << axis.cross(0.5 * (ga + gb)).cwiseProduct(turn), 0.0;
      rows.push_back({x, (gb - ga).dot(axis), sigma, false});
    }
  }
  GyroFit fit;
  Eigen::Matrix4d a = Eigen::Matrix4d::Zero();
  Vector4d b = Vector4d::Zero(), answer = Vector4d::Zero();
  double scale[2] = {1e9, 1e9};
  for (int round = 0; round < 3; ++round) {
    a.setZero(), b.setZero();
    std::array<std::vector<double>, 2> residuals;
    for (const Row& row : rows) {
      const double r = std::abs(row.y - row.x.dot(answer)) / row.sigma;
      residuals[row.course ? 0 : 1].push_back(r);
      const double spread = std::max(scale[row.course ? 0 : 1], 1e-6);
      const double weight = std::min(1.0, 2.5 * spread / std::max(r, 1e-9)) /
                            (row.sigma * row.sigma * std::min(spread * spread, 1e6));
      a += weight * row.x * row.x.transpose(), b += weight * row.y * row.x;
    }
    Eigen::Matrix4d regular = a;
    regular.diagonal().array() += 1e-12 * a.trace() + 1e-30;
    const Eigen::LDLT<Eigen::Matrix4d> solver(regular);
    answer = solver.solve(b);
    if (!answer.allFinite()) return GyroFit{};
    for (int j = 0; j < 2; ++j)
      if (!residuals[static_cast<std::size_t>(j)].empty())
        scale[j] = 1.5 * upper_median_of(residuals[static_cast<std::size_t>(j)]);
    const Eigen::Matrix4d inverse = solver.solve(Eigen::Matrix4d::Identity());
    fit.sigma =
        (inverse.diagonal().head<3>() / std::max(spacing_s, 0.05)).cwiseMax(0.0).cwiseSqrt();
  }
  fit.gain = answer.head<3>();
  return fit;
}

}  // namespace wayfare::nav
