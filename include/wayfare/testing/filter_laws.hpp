#pragma once

// The laws of a Kalman filter, as checks on any state, process and measurement:
//
//   FilterLaws<MyState>{{my_filter}}.check_update(my_measurement);
//   FilterLaws<MyState>{{my_filter}}.check_predict(my_process, my_input);
//
// Checks on Gaussians and on samples drawn from one. The bounds follow from the number of samples,
// not from the results of a particular run.

#include <cmath>
#include <cstddef>
#include <vector>

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/LU>

#include <wayfare/core/gaussian.hpp>
#include <wayfare/filter/ekf.hpp>
#include <wayfare/testing/detail/positive_definite.hpp>

namespace wayfare::testing {

/// Exactly symmetric, and positive definite after scaling by the standard deviations.
template <class Derived>
[[nodiscard]] ::testing::AssertionResult is_covariance(
    const Eigen::MatrixBase<Derived>& covariance) {
  // NOLINTNEXTLINE(performance-unnecessary-copy-initialization): of other scalars a cast is an
  // expression
  const Eigen::MatrixXd p = covariance.template cast<double>();
  if (!p.allFinite()) return ::testing::AssertionFailure() << "not finite";
  if (p != p.transpose()) {
    return ::testing::AssertionFailure()
           << "not symmetric, by " << (p - p.transpose()).cwiseAbs().maxCoeff();
  }
  if ((p.diagonal().array() <= 0).any()) {
    return ::testing::AssertionFailure() << "variances " << p.diagonal().transpose();
  }
  const Eigen::VectorXd scale = p.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd correlation = scale.asDiagonal() * p * scale.asDiagonal();
  const double least = least_pivot(correlation);
  if (!(least > 0)) {
    return ::testing::AssertionFailure()
           << "not positive definite: a pivot of the correlations is " << least;
  }
  return ::testing::AssertionSuccess();
}

/// Fails the current test where a prediction or an update of `filter` breaks a law of Kalman
/// filters.
template <Manifold M>
struct FilterLaws {
  Ekf<M> filter;  ///< with the state and covariance to start from
  /// Greatest difference between two ways to compute a covariance, relative to √(PᵢᵢPⱼⱼ).
  double tolerance = 1e-9;

  using Scalar = typename ManifoldTraits<M>::Scalar;              ///< of the state
  using Square = SquareOf<M>;                                     ///< covariances
  using Row = Eigen::Matrix<Scalar, 1, ManifoldTraits<M>::kDof>;  ///< a row of H

  /// Prediction keeps P a covariance, and equals Φ P Φᵀ + Q if the process gives Φ and Q.
  template <class Process, class... Input>
  void check_predict(const Process& process, const Input&... input) const {
    Ekf<M> after = filter;
    after.predict(process, input...);
    EXPECT_TRUE(is_covariance(after.covariance()));
    const auto step = process(filter.state(), input...);
    if constexpr (DenseProcessStep<decltype(step), M>) {
      expect_same(after.covariance(),
                  step.phi * filter.covariance() * step.phi.transpose() + step.q, "ΦPΦᵀ + Q");
    } else if constexpr (requires { step.phi(); }) {
      const Square phi = step.phi();
      expect_same(after.covariance(), phi * filter.covariance() * phi.transpose() + step.q(),
                  "ΦPΦᵀ + Q");
    }
  }

  /// The three laws of an update with a scalar or a vector measurement.
  template <class Model>
  void check_update(const Model& model) const {
    update_is_josephs(model);
    information_adds_up(model);
    refused_changes_nothing(model);
  }

  /// (I − K H) P (I − K H)ᵀ + K R Kᵀ, evaluated directly.
  template <class Model>
  void update_is_josephs(const Model& model) const {
    const auto m = dense(measure(model, filter.state()));
    const Square& p = filter.covariance();
    const auto k =
        (p * m.rows.transpose() * (m.rows * p * m.rows.transpose() + m.covariance).inverse())
            .eval();
    const Square keep = Square::Identity() - k * m.rows;
    const Square joseph = keep * p * keep.transpose() + k * m.covariance * k.transpose();
    Ekf<M> after = filter;
    after.update(model);
    EXPECT_TRUE(is_covariance(after.covariance()));
    expect_same(after.covariance(), joseph, "Joseph's form");
    EXPECT_LE((ManifoldTraits<M>::minus(after.state(),
                                        ManifoldTraits<M>::plus(filter.state(), k * m.innovation)))
                  .norm(),
              tolerance * (1.0 + m.innovation.norm()))
        << "K ν";
  }

  /// P⁺⁻¹ = P⁻¹ + Hᵀ R⁻¹ H, tested as P⁺ (P⁻¹ + Hᵀ R⁻¹ H) = I.
  template <class Model>
  void information_adds_up(const Model& model) const {
    const auto m = dense(measure(model, filter.state()));
    Ekf<M> after = filter;
    after.update(model);
    const Square information =
        filter.covariance().inverse() + m.rows.transpose() * m.covariance.inverse() * m.rows;
    expect_same(information.inverse(), after.covariance(), "information adds up");
  }

  /// Gated measurements and NaN leave state and covariance unchanged, bit by bit.
  template <class Model>
  void refused_changes_nothing(const Model& model) const {
    for (const Scalar bad : {Scalar(NAN), Scalar(INFINITY), Scalar(1e20)}) {
      Ekf<M> after = filter;
      const auto u = after.update(
          [&](const M& x) {
            auto m = measure(model, x);
            if constexpr (ScalarMeasurementModel<Model, M>)
              m.innovation = bad;
            else
              m.innovation[0] = bad;
            return m;
          },
          Scalar(5));
      EXPECT_FALSE(u.accepted);
      EXPECT_EQ(after.covariance(), filter.covariance());
      EXPECT_EQ(ManifoldTraits<M>::minus(after.state(), filter.state()).norm(), Scalar(0));
    }
  }

  /// A measurement with all of H.
  template <int Rows>
  using Dense =
      VectorMeasurement<Scalar, Rows, Eigen::Matrix<Scalar, Rows, ManifoldTraits<M>::kDof>>;

  /// With every column of H, those of zeros too.
  template <class R>
  [[nodiscard]] static Dense<1> dense(const ScalarMeasurement<Scalar, R>& m) {
    using One = Eigen::Matrix<Scalar, 1, 1>;
    return {One(m.innovation), dense(m.row), One(m.variance)};
  }
  /// With every column of H, those of zeros too.
  template <int Rows, int K>
  [[nodiscard]] static Dense<Rows> dense(
      const VectorMeasurement<Scalar, Rows, SparseRows<Scalar, Rows, K>>& m) {
    Dense<Rows> all{m.innovation, {}, m.covariance};
    all.rows.setZero();
    for (std::size_t k = 0; k < K; ++k)
      all.rows.col(m.rows.index[k]) += m.rows.value.col(static_cast<Eigen::Index>(k));
    return all;
  }
  /// Itself.
  template <int Rows>
  [[nodiscard]] static Dense<Rows> dense(const Dense<Rows>& m) {
    return m;
  }
  /// With every column, those of zeros too.
  template <int K>
  [[nodiscard]] static Row dense(const SparseRow<Scalar, K>& row) {
    Row h = Row::Zero();
    for (std::size_t k = 0; k < K; ++k) h[row.index[k]] += row.value[k];
    return h;
  }
  /// Itself.
  [[nodiscard]] static Row dense(const Row& row) { return row; }

  /// Fails where an element differs by more than `tolerance` times √(PᵢᵢPⱼⱼ) of `expected`.
  void expect_same(const Square& actual, const Square& expected, const char* law) const {
    const auto s = expected.diagonal().cwiseAbs().cwiseSqrt().eval();
    for (int i = 0; i < s.size(); ++i) {
      for (int j = 0; j < s.size(); ++j) {
        EXPECT_LE(std::abs(actual(i, j) - expected(i, j)), tolerance * s[i] * s[j])
            << law << ", entry " << i << ", " << j;
      }
    }
  }
};

/// Finite, symmetric, and no eigenvalue below −`tolerance` times the largest element.
inline void expect_covariance(const Eigen::MatrixXd& matrix, double tolerance = 1e-12) {
  ASSERT_TRUE(matrix.allFinite()) << matrix;
  const double size = matrix.cwiseAbs().maxCoeff();
  EXPECT_LE((matrix - matrix.transpose()).cwiseAbs().maxCoeff(), tolerance * size) << matrix;
  const Eigen::MatrixXd raised =
      matrix + tolerance * size * Eigen::MatrixXd::Identity(matrix.rows(), matrix.cols());
  EXPECT_GT(least_pivot(raised), 0.0) << matrix;
}

/// As expect_samples_follow below; `differences`: sample ⊖ mean, one column each.
inline void expect_differences_follow(const Eigen::MatrixXd& covariance,
                                      const Eigen::MatrixXd& differences, double sigmas,
                                      double curvature) {
  const Eigen::LLT<Eigen::MatrixXd> llt(covariance);
  ASSERT_EQ(llt.info(), Eigen::Success) << "not positive definite:\n" << covariance;
  const Eigen::MatrixXd z = llt.matrixL().solve(differences);
  const auto n = static_cast<double>(z.cols());
  const auto dof = static_cast<double>(z.rows());
  const Eigen::VectorXd mean = z.rowwise().mean();
  const Eigen::MatrixXd second = z * z.transpose() / n;
  const double one = sigmas / std::sqrt(n);
  EXPECT_LE(mean.cwiseAbs().maxCoeff(), one + curvature) << "mean of the whitened samples " << mean;
  Eigen::MatrixXd excess = second;
  excess.diagonal().array() -= 1.0;
  EXPECT_LE(std::abs(excess.trace()), std::sqrt(2.0 * dof) * one + dof * curvature)
      << "normalised error squared";
  EXPECT_LE(excess.diagonal().cwiseAbs().maxCoeff(), std::sqrt(2.0) * one + curvature)
      << "variances of the whitened samples\n"
      << second;
  excess.diagonal().setZero();
  EXPECT_LE(excess.cwiseAbs().maxCoeff(), one + curvature) << "correlations\n" << second;
}

/// Tests `samples` against `g` (positive definite) by their first two moments. With z the whitened
/// differences from the mean, n samples of dimension d give
///   mean of z            : variance 1/n each
///   mean of zᵢzⱼ, i ≠ j  : variance 1/n
///   mean of zᵢ²          : variance 2/n about 1
///   mean of zᵀz          : variance 2d/n about d  (the mean normalised error squared)
/// `sigmas` standard deviations are allowed; six fail about one in 10⁹ valid sample sets.
/// `curvature` is added to each bound, for samples that are Gaussian to first order only.
template <Manifold M>
void expect_samples_follow(const Gaussian<M>& g, const std::vector<M>& samples, double sigmas = 6.0,
                           double curvature = 0.0) {
  Eigen::MatrixXd differences(ManifoldTraits<M>::kDof, static_cast<Eigen::Index>(samples.size()));
  for (Eigen::Index i = 0; i < differences.cols(); ++i) {
    const auto d = ManifoldTraits<M>::minus(samples[static_cast<std::size_t>(i)], g.mean);
    for (int k = 0; k < ManifoldTraits<M>::kDof; ++k) differences(k, i) = d[k];
  }
  expect_differences_follow(g.covariance.template cast<double>(), differences, sigmas, curvature);
}

}  // namespace wayfare::testing
