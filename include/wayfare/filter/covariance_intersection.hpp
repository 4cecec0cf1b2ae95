#pragma once

// Fusion of estimates whose correlation is not known.

#include <cmath>
#include <optional>

#include <Eigen/Cholesky>
#include <Eigen/Core>

namespace wayfare {

/// The fusion of a state and a measurement: the correction of the state (in its tangent space), its
/// new covariance, and the weight of the measurement.
template <int kStates>
struct Intersected {
  Eigen::Matrix<double, kStates, 1> correction;        ///< of the state, in its tangent space
  Eigen::Matrix<double, kStates, kStates> covariance;  ///< of the corrected state
  double omega = 0.0;                                  ///< weight of the measurement, in [0, 1)
};

namespace detail {

/// ω in [0, 1) that maximises ln det P⁺⁻¹: with B = L⁻¹ C P Cᵀ L⁻ᵀ, R = L Lᵀ, that is (n − m) ln(1
/// − ω) + ln det((1 − ω) I + ω B), concave in ω.
template <int kRows>
double best_omega(const Eigen::Matrix<double, kRows, kRows>& B, int unmeasured) {
  using Matrix = Eigen::Matrix<double, kRows, kRows>;
  const Matrix identity = Matrix::Identity();
  const auto slope = [&](double w) {
    const Matrix mixed = (1 - w) * identity + w * B;
    return mixed.llt().solve(B - identity).trace() - unmeasured / (1 - w);
  };
  // Where everything is measured far more accurately than known, the optimum is ω = 1, the
  // measurement alone: the limit keeps quotients by 1 − ω finite.
  double low = 0, high = 1 - 1e-6;
  if (!(slope(low) > 0)) return 0.0;
  if (slope(high) > 0) return high;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (slope(middle) > 0 ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace detail

/// Fuses a state of covariance P with a measurement `innovation` = z − h(x) of covariance R and
/// rows C = ∂h/∂x whose errors may have any correlation with the state's (Julier and Uhlmann 1997):
/// P⁺⁻¹ = (1 − ω) P⁻¹ + ω Cᵀ R⁻¹ C, in covariance form K = P Cᵀ ((1 − ω)/ω R + C P Cᵀ)⁻¹, x⁺ = x +
/// K · innovation, P⁺ = (P − K C P) / (1 − ω), with the ω that minimises det P⁺. P⁺ is consistent
/// where P and R are. nullopt where P or R is not positive definite, or an input or result is not
/// finite.
template <int kStates, int kRows>
[[nodiscard]] std::optional<Intersected<kStates>> covariance_intersection(
    const Eigen::Matrix<double, kStates, kStates>& P,
    const Eigen::Matrix<double, kRows, kStates>& C, const Eigen::Matrix<double, kRows, kRows>& R,
    const Eigen::Matrix<double, kRows, 1>& innovation) {
  static_assert(kRows <= kStates);
  if (!P.allFinite() || !C.allFinite() || !R.allFinite() || !innovation.allFinite()) return {};
  const Eigen::LLT<Eigen::Matrix<double, kRows, kRows>> of_R(R);
  if (of_R.info() != Eigen::Success || P.llt().info() != Eigen::Success) return {};
  const Eigen::Matrix<double, kRows, kStates> CP = C * P;
  const Eigen::Matrix<double, kRows, kRows> S = CP * C.transpose();
  const auto L = of_R.matrixL();
  const Eigen::Matrix<double, kRows, kRows> half = L.solve(S);
  const Eigen::Matrix<double, kRows, kRows> B = L.solve(half.transpose());
  Intersected<kStates> fused;
  fused.omega = detail::best_omega<kRows>(0.5 * (B + B.transpose()), kStates - kRows);
  if (fused.omega == 0.0) {
    fused.correction.setZero();
    fused.covariance = P;
    return fused;
  }
  const double state_weight = 1 - fused.omega;
  const Eigen::Matrix<double, kRows, kRows> inflated = state_weight / fused.omega * R + S;
  const Eigen::Matrix<double, kStates, kRows> K = inflated.llt().solve(CP).transpose();
  fused.correction = K * innovation;
  // Joseph's form, which stays positive definite, with R scaled by (1 − ω)/ω.
  Eigen::Matrix<double, kStates, kStates> A = -K * C;
  A.diagonal().array() += 1;
  fused.covariance =
      (A * P * A.transpose() + state_weight / fused.omega * K * R * K.transpose()) / state_weight;
  fused.covariance = 0.5 * (fused.covariance + fused.covariance.transpose()).eval();
  if (!fused.correction.allFinite() || !fused.covariance.allFinite()) return {};
  return fused;
}

}  // namespace wayfare
