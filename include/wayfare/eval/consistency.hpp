#pragma once

// Consistency of an estimator: normalised squared errors over repeated runs against their bounds
// (Bar-Shalom, Li and Kirubarajan 2001, section 5.4.2).

#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <wayfare/core/statistics.hpp>

namespace wayfare::eval {

/// eᵀ P⁻¹ e of an estimation error (NEES) or an innovation (NIS) and its covariance. Its mean is
/// its dimension if P is consistent. NaN if P is not positive definite.
template <class Vector, class Matrix>
[[nodiscard]] double normalised_squared(const Eigen::MatrixBase<Vector>& error,
                                        const Eigen::MatrixBase<Matrix>& covariance) {
  // Scaled to a unit diagonal: states range from metres to microradians.
  const auto scale = covariance.diagonal().cwiseSqrt().cwiseInverse().eval();
  const Eigen::LLT<typename Matrix::PlainObject> llt(
      (scale.asDiagonal() * covariance * scale.asDiagonal()).eval());
  if (llt.info() != Eigen::Success) return std::numeric_limits<double>::quiet_NaN();
  return llt.matrixL().solve(scale.cwiseProduct(error).eval()).squaredNorm();
}

/// A closed interval.
struct Interval {
  double low = 0.0,  ///< its lower bound
      high = 0.0;    ///< its upper bound
  /// Bounds included; false for NaN.
  [[nodiscard]] bool contains(double x) const { return x >= low && x <= high; }
};

/// Symmetric `probability` interval of the mean of `samples` independent values of dimension `dof`.
[[nodiscard]] inline Interval mean_nees_bounds(int dof, std::size_t samples,
                                               double probability = 0.95) {
  const auto n = static_cast<double>(samples);
  const double outside = 0.5 * (1.0 - probability);
  return {chi_square_quantile(outside, dof * n) / n,
          chi_square_quantile(1.0 - outside, dof * n) / n};
}

/// Mean of independent values, such as those of whole runs (not of neighbouring epochs), and its
/// standard error from their sample variance.
class IndependentMean {
 public:
  /// Takes one value.
  void add(double x) {
    ++count_;
    const double before = x - mean_;
    mean_ += before / static_cast<double>(count_);
    squares_ += before * (x - mean_);
  }
  /// Number of values.
  [[nodiscard]] std::size_t count() const { return count_; }
  /// 0 without values.
  [[nodiscard]] double mean() const { return mean_; }
  /// Standard deviation of one value; NaN for fewer than two.
  [[nodiscard]] double deviation() const {
    if (count_ < 2) return std::numeric_limits<double>::quiet_NaN();
    return std::sqrt(squares_ / (static_cast<double>(count_) - 1.0));
  }
  /// Of the mean: deviation() / √count.
  [[nodiscard]] double standard_error() const {
    return deviation() / std::sqrt(static_cast<double>(count_));
  }

 private:
  std::size_t count_ = 0;
  double mean_ = 0.0, squares_ = 0.0;
};

/// Normalised squared errors of many runs of the same length: one mean per epoch over the runs.
/// Also for innovations (NIS), each of dimension one.
class NeesOverRuns {
 public:
  /// `dof`: dimension of the errors; `epochs`: of every run.
  NeesOverRuns(int dof, std::size_t epochs) : dof_(dof), sums_(epochs, 0.0), counts_(epochs, 0) {}

  /// A value, or the sum of `count` values; not finite, it counts as infinite.
  void add(std::size_t epoch, double sum, std::size_t count = 1) {
    WAYFARE_EXPECTS(epoch < sums_.size(), "the epoch is out of range");
    sums_[epoch] += std::isfinite(sum) ? sum : std::numeric_limits<double>::infinity();
    counts_[epoch] += count;
  }
  /// Over all epochs.
  [[nodiscard]] std::size_t count() const {
    return std::accumulate(counts_.begin(), counts_.end(), std::size_t{0});
  }
  /// As given.
  [[nodiscard]] std::size_t epochs() const { return sums_.size(); }
  /// NaN without values.
  [[nodiscard]] double mean(std::size_t epoch) const {
    return sums_[epoch] / static_cast<double>(counts_[epoch]);
  }
  /// Over all values; NaN without any.
  [[nodiscard]] double mean_of_all() const {
    double sum = 0.0, count = 0.0;
    for (std::size_t k = 0; k < epochs(); ++k)
      sum += sums_[k], count += static_cast<double>(counts_[k]);
    return sum / count;
  }
  /// Fraction of epochs with a mean within its bounds: about `probability` for a consistent
  /// estimator. Its variance exceeds that for independent values, since errors are correlated over
  /// epochs (innovations are not).
  [[nodiscard]] double share_within(double probability = 0.95) const {
    double inside = 0.0, epochs_with_values = 0.0;
    for (std::size_t k = 0; k < epochs(); ++k) {
      if (counts_[k] == 0) continue;
      epochs_with_values += 1.0;
      if (mean_nees_bounds(dof_, counts_[k], probability).contains(mean(k))) inside += 1.0;
    }
    return inside / epochs_with_values;
  }

 private:
  int dof_;
  std::vector<double> sums_;
  std::vector<std::size_t> counts_;
};

/// Fraction of errors within k standard deviations per component: 0.6827, 0.9545, 0.9973 for k = 1,
/// 2, 3 if the estimator is consistent.
template <int N>
class SigmaCount {
 public:
  using Vector = Eigen::Matrix<double, N, 1>;  ///< one component for each error

  /// An estimation error and its standard deviations, component by component.
  void add(const Vector& error, const Vector& sigma) {
    ++count_;
    for (int k = 1; k <= 3; ++k)
      within_.col(k - 1).array() +=
          (error.array().abs() <= k * sigma.array()).template cast<double>();
  }
  /// Number of errors.
  [[nodiscard]] std::size_t count() const { return count_; }
  /// `k` in {1, 2, 3}.
  [[nodiscard]] Vector share(int k) const {
    return within_.col(k - 1) / static_cast<double>(count_);
  }

 private:
  std::size_t count_ = 0;
  Eigen::Matrix<double, N, 3> within_ = Eigen::Matrix<double, N, 3>::Zero();
};

}  // namespace wayfare::eval
