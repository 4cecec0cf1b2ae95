#include "gnss/robust_solve.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace wayfare::robust {
namespace {

/// The normal equations for given weights; unobserved unknowns (the clock of a system without
/// satellites in use) are fixed at zero.
class Normal {
 public:
  explicit Normal(int unknowns)
      : matrix_(Eigen::MatrixXd::Zero(unknowns, unknowns)),
        side_(Eigen::VectorXd::Zero(unknowns)) {}

  void add(const Eigen::VectorXd& row, double value, double weight) {
    if (weight == 0.0) return;
    matrix_.noalias() += weight * row * row.transpose();
    side_ += weight * value * row;
  }

  [[nodiscard]] int unobserved() const {
    return static_cast<int>((matrix_.diagonal().array() == 0.0).count());
  }

  std::optional<Eigen::VectorXd> solve() {
    // Position or velocity, which come first, must be observed; a clock need not be.
    if (!(matrix_.diagonal().head<3>().array() > 0.0).all()) return std::nullopt;
    fix_unobserved();
    const Eigen::VectorXd scale = matrix_.diagonal().cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXd scaled = scale.asDiagonal() * matrix_ * scale.asDiagonal();
    const Eigen::LDLT<Eigen::MatrixXd> factors(scaled);
    if (factors.info() != Eigen::Success || !(factors.vectorD().minCoeff() > 1e-9))
      return std::nullopt;
    return scale.cwiseProduct(factors.solve(scale.cwiseProduct(side_)));
  }

  std::optional<Eigen::MatrixXd> inverse() {
    fix_unobserved();
    const Eigen::LDLT<Eigen::MatrixXd> factors(matrix_);
    if (factors.info() != Eigen::Success || !(factors.vectorD().minCoeff() > 0.0))
      return std::nullopt;
    return factors.solve(Eigen::MatrixXd::Identity(matrix_.rows(), matrix_.cols()));
  }

 private:
  void fix_unobserved() {
    for (Eigen::Index i = 0; i < matrix_.rows(); ++i)
      if (matrix_(i, i) == 0.0) matrix_(i, i) = 1.0;
  }

  Eigen::MatrixXd matrix_;
  Eigen::VectorXd side_;
};

Normal normal_of(const System& s, const Eigen::VectorXd& weight) {
  Normal normal(s.unknowns());
  for (int i = 0; i < s.rows(); ++i) {
    const double given = i < s.measurements() ? weight[i] : 1.0;
    normal.add(s[i].a, s[i].value, given / (s[i].sigma * s[i].sigma));
  }
  return normal;
}

/// Residual in σ.
double normalised(const System& s, const Eigen::VectorXd& x, int i) {
  return (s[i].value - s[i].a.dot(x)) / s[i].sigma;
}

double robust_cost(const System& s, const Eigen::VectorXd& x, double scale) {
  double cost = 0.0;
  for (int i = 0; i < s.rows(); ++i) {
    const double r = normalised(s, x, i);
    cost += i < s.measurements() ? scale * scale * std::log1p(r * r / (scale * scale)) : r * r;
  }
  return cost;
}

/// The solution of least robust cost among those with up to two measurements removed.
Eigen::VectorXd best_start(const System& s, const Eigen::VectorXd& all, double scale) {
  constexpr int kMost = 100;  // its time grows with the cube of the number
  const int n = s.measurements();
  if (n > kMost) return all;
  Eigen::VectorXd best = all, weight = Eigen::VectorXd::Ones(n);
  double least = robust_cost(s, all, scale);
  const auto attempt = [&] {
    if (const auto x = normal_of(s, weight).solve()) {
      const double cost = robust_cost(s, *x, scale);
      if (cost < least) least = cost, best = *x;
    }
  };
  const bool pairs = s.redundancy() >= 3;
  for (int i = 0; i < n && s.redundancy() >= 2; ++i) {
    weight[i] = 0.0;
    attempt();
    for (int j = i + 1; j < n && pairs; ++j) {
      weight[j] = 0.0;
      attempt();
      weight[j] = 1.0;
    }
    weight[i] = 1.0;
  }
  return best;
}

/// Iteratively reweighted least squares; returns the last weights in `weight`.
Eigen::VectorXd solve_reweighted(const System& s, Eigen::VectorXd x, const Options& options,
                                 Eigen::VectorXd& weight) {
  for (int iteration = 0; iteration < 50; ++iteration) {
    for (int i = 0; i < s.measurements(); ++i) {
      const double r = normalised(s, x, i) / options.scale;
      weight[i] = 1.0 / (1.0 + r * r);
    }
    const auto next = normal_of(s, weight).solve();
    if (!next) break;
    const double moved = (*next - x).norm();
    x = *next;
    if (moved < 1e-6) break;
  }
  return x;
}

/// Residuals and covariance of a solution from its unknowns and weights.
std::optional<Solution> complete(const System& s, const Eigen::VectorXd& x,
                                 const Eigen::VectorXd& weight) {
  Solution solution{x, Eigen::VectorXd(s.measurements()), weight, {}, 0.0, 0};
  Normal normal = normal_of(s, weight);
  int used = s.rows() - s.measurements();
  for (int i = 0; i < s.rows(); ++i) {
    const double r = normalised(s, x, i);
    if (i < s.measurements()) {
      solution.residual[i] = r * s[i].sigma;
      if (weight[i] > 0.0) ++used;
    }
    if (i >= s.measurements() || weight[i] > 0.0) solution.chi_square += r * r;
  }
  solution.redundancy = used - (s.unknowns() - normal.unobserved());
  const auto inverse = normal.inverse();
  if (!inverse) return std::nullopt;
  const double excess = solution.redundancy > 0 ? solution.chi_square / solution.redundancy : 1.0;
  solution.covariance = std::max(excess, 1.0) * *inverse;
  return solution;
}

}  // namespace

Eigen::MatrixXd System::unweighted_covariance(const Eigen::VectorXd& weight) const {
  Normal normal(unknowns_);
  for (int i = 0; i < rows(); ++i)
    if (i >= measurements_ || weight[i] > 0.0) normal.add((*this)[i].a, 0.0, 1.0);
  const auto inverse = normal.inverse();
  if (inverse) return *inverse;
  return Eigen::MatrixXd::Constant(unknowns_, unknowns_, std::numeric_limits<double>::infinity());
}

std::optional<Solution> solve(const System& s, const Options& options) {
  if (s.redundancy() < 0) return std::nullopt;
  Eigen::VectorXd weight = Eigen::VectorXd::Ones(s.measurements());
  const auto all = normal_of(s, weight).solve();
  if (!all) return std::nullopt;
  const std::optional<Solution> plain = complete(s, *all, weight);
  if (!options.exclude || !plain || s.redundancy() < 1 || plain->chi_square <= options.threshold)
    return plain;
  const Eigen::VectorXd start = best_start(s, *all, options.scale);
  const Eigen::VectorXd robust = solve_reweighted(s, start, options, weight);
  for (int i = 0; i < s.measurements(); ++i)
    if (std::abs(normalised(s, robust, i)) > options.exclusion_sigma) weight[i] = 0.0;
  // Without the outliers, the others get their full weights.
  const auto last = normal_of(s, weight).solve();
  if (!last) return plain;
  const std::optional<Solution> solution = complete(s, *last, weight);
  return solution && solution->redundancy >= 0 ? solution : plain;
}

}  // namespace wayfare::robust
