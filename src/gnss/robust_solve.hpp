#pragma once

// Private: robust linear least squares with outliers.

#include <optional>
#include <vector>

#include <Eigen/Core>

namespace wayfare::robust {

struct Row {
  Eigen::VectorXd a;
  double value, sigma;
};

/// Rows a·x = y with standard deviations. The unknowns are three of position or velocity, then
/// clocks; priors are rows that are never excluded and come last.
class System {
 public:
  explicit System(int unknowns) : unknowns_(unknowns) {}

  void add(const Eigen::VectorXd& row, double value, double sigma) {
    rows_.push_back({row, value, sigma});
    ++measurements_;
  }
  /// After all measurements.
  void add_prior(const Eigen::VectorXd& row, double value, double sigma) {
    rows_.push_back({row, value, sigma});
  }

  [[nodiscard]] int unknowns() const { return unknowns_; }
  [[nodiscard]] int measurements() const { return measurements_; }
  [[nodiscard]] int rows() const { return static_cast<int>(rows_.size()); }
  /// Degrees of freedom: rows less unknowns.
  [[nodiscard]] int redundancy() const { return rows() - unknowns_; }
  [[nodiscard]] const Row& operator[](int i) const { return rows_[static_cast<std::size_t>(i)]; }

  /// (AᵀA)⁻¹ over the measurements with non-zero weight and all priors; infinite if singular.
  [[nodiscard]] Eigen::MatrixXd unweighted_covariance(const Eigen::VectorXd& weight) const;

 private:
  int unknowns_;
  int measurements_ = 0;
  std::vector<Row> rows_;
};

struct Options {
  bool exclude = true;
  double threshold = 0.0;  ///< of Σ (r/σ)² for all rows
  double scale = 2.0;
  double exclusion_sigma = 5.0;
};

struct Solution {
  Eigen::VectorXd step;
  Eigen::VectorXd residual;    ///< of the measurements
  Eigen::VectorXd weight;      ///< of the measurements, 1 to 0 (excluded)
  Eigen::MatrixXd covariance;  ///< scaled up if the residuals exceed their σ
  double chi_square = 0.0;     ///< of the rows in use
  int redundancy = 0;          ///< of the rows in use
};

/// None if the rows do not determine the unknowns.
[[nodiscard]] std::optional<Solution> solve(const System& system, const Options& options);

/// A measurement's mixture: direct, or with a further error of this mean and deviation.
struct Mixture {
  std::vector<double> direct_sigma, probability;  ///< of each measurement; of the further error
  double mean = 0.0, sigma = 1.0;
  double variance_factor = 1.0;
};

/// The mean over the local maxima of the mixture's likelihood. `weight`: the probability of being
/// direct, zero below one half. None if nothing is found.
[[nodiscard]] std::optional<Solution> solve_mixture(const System& system, const Mixture& mixture);

}  // namespace wayfare::robust
