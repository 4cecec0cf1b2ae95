#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "gnss/robust_solve.hpp"

namespace wayfare::robust {
namespace {

/// No error is as large: maxima beyond are of degenerate geometries.
constexpr double kFarthest_m = 1000.0;
/// Outliers of any size stay possible.
constexpr double kLeastLikelihood = 1e-12;

/// A local maximum of the likelihood, as a normal distribution.
struct Maximum {
  Eigen::VectorXd x;
  Eigen::MatrixXd covariance;
  double log_likelihood = 0.0;
};

/// A measurement of residual `r`: its likelihood, the probability that it is direct, and the
/// derivatives of the logarithm of the likelihood.
struct Term {
  double likelihood, direct, weight, score, information;

  Term(const Mixture& m, std::size_t i, double r) {
    const double s0 = m.direct_sigma[i], s1 = std::hypot(s0, m.sigma), d = r - m.mean;
    const double l0 = (1.0 - m.probability[i]) * std::exp(-0.5 * r * r / (s0 * s0)) / s0;
    const double l1 = m.probability[i] * std::exp(-0.5 * d * d / (s1 * s1)) / s1 + kLeastLikelihood;
    likelihood = l0 + l1;
    direct = l0 / likelihood;
    const double w0 = 1.0 / (s0 * s0), w1 = 1.0 / (s1 * s1);
    weight = direct * w0 + (1.0 - direct) * w1;
    score = direct * w0 * r + (1.0 - direct) * w1 * d;
    // Observed information: less what is unknown of the hypothesis (Louis 1982).
    const double between = w0 * r - w1 * d;
    information = weight - direct * (1.0 - direct) * between * between;
  }
};

double residual(const System& s, const Eigen::VectorXd& x, int i) {
  return s[i].value - s[i].a.dot(x);
}

/// Iterates expectation and maximisation from `x`.
std::optional<Maximum> climb(const System& s, const Mixture& mixture, Eigen::VectorXd x) {
  const int n = s.unknowns();
  Maximum top;
  Eigen::MatrixXd complete, observed;
  for (int iteration = 0; iteration < 60; ++iteration) {
    complete.setZero(n, n), observed.setZero(n, n);
    Eigen::VectorXd side = Eigen::VectorXd::Zero(n);
    top.log_likelihood = 0.0;
    for (int i = 0; i < s.rows(); ++i) {
      const double r = residual(s, x, i), w = 1.0 / (s[i].sigma * s[i].sigma);
      const Eigen::MatrixXd outer = s[i].a * s[i].a.transpose();
      if (i < s.measurements()) {
        const Term t(mixture, static_cast<std::size_t>(i), r);
        top.log_likelihood += std::log(t.likelihood);
        complete += t.weight * outer, observed += t.information * outer;
        side += t.score * s[i].a;
      } else {
        top.log_likelihood -= 0.5 * w * r * r;
        complete += w * outer, observed += w * outer;
        side += w * r * s[i].a;
      }
    }
    const Eigen::LLT<Eigen::MatrixXd> factors(complete);
    if (factors.info() != Eigen::Success) return std::nullopt;
    const Eigen::VectorXd step = factors.solve(side);
    if (!step.allFinite()) return std::nullopt;
    x += step;
    if (step.norm() < 1e-3) break;
  }
  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(n, n);
  const Eigen::LLT<Eigen::MatrixXd> factors(observed);
  if (factors.info() == Eigen::Success) top.covariance = factors.solve(identity);
  // Where the maximum is flat, that of known hypotheses.
  if (factors.info() != Eigen::Success || !(top.covariance.trace() < 1e6))
    top.covariance = complete.llt().solve(identity);
  top.x = x;
  if (!(x.head<3>().norm() < kFarthest_m) || !(top.covariance.trace() < 1e6)) return std::nullopt;
  return top;
}

enum class Assumed { given, left_out, further };

/// Weighted least squares under a hypothesis of the measurements, by their given σ or with the
/// further error.
std::optional<Eigen::VectorXd> solve_assumed(const System& s, const Mixture& mixture,
                                             const std::vector<Assumed>& assumed) {
  const int n = s.unknowns();
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd side = Eigen::VectorXd::Zero(n);
  for (int i = 0; i < s.rows(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    const Assumed what = i < s.measurements() ? assumed[k] : Assumed::given;
    if (what == Assumed::left_out) continue;
    const bool further = what == Assumed::further;
    const double sigma = further ? std::hypot(mixture.direct_sigma[k], mixture.sigma) : s[i].sigma;
    const double w = 1.0 / (sigma * sigma);
    matrix += w * s[i].a * s[i].a.transpose();
    side += w * (s[i].value - (further ? mixture.mean : 0.0)) * s[i].a;
  }
  const Eigen::LDLT<Eigen::MatrixXd> factors(matrix);
  if (factors.info() != Eigen::Success || !(factors.vectorD().minCoeff() > 1e-9))
    return std::nullopt;
  return factors.solve(side);
}

/// The distinct maxima reached from the solutions with up to two measurements left out; where the
/// others would not determine them, from those of every hypothesis.
std::vector<Maximum> maxima(const System& s, const Mixture& mixture) {
  constexpr int kMostOfPairs = 20;  // the time grows with the cube of the number
  constexpr int kMostOfAll = 8;     // 256 hypotheses
  const int n = s.measurements();
  std::vector<Maximum> found;
  std::vector<Assumed> assumed(static_cast<std::size_t>(n), Assumed::given);
  const auto attempt = [&] {
    const auto start = solve_assumed(s, mixture, assumed);
    if (!start) return;
    auto top = climb(s, mixture, *start);
    if (!top) return;
    for (const Maximum& other : found)
      if ((other.x - top->x).norm() < 0.5) return;
    found.push_back(*std::move(top));
  };
  if (s.redundancy() < 2 && n <= kMostOfAll) {
    for (unsigned hypothesis = 0; hypothesis < (1U << n); ++hypothesis) {
      for (std::size_t i = 0; i < assumed.size(); ++i)
        assumed[i] = (hypothesis >> i & 1U) != 0 ? Assumed::further : Assumed::given;
      attempt();
    }
    return found;
  }
  attempt();
  for (std::size_t i = 0; i < assumed.size() && s.redundancy() >= 1; ++i) {
    assumed[i] = Assumed::left_out;
    attempt();
    for (std::size_t j = i + 1; j < assumed.size() && n <= kMostOfPairs && s.redundancy() >= 2;
         ++j) {
      assumed[j] = Assumed::left_out;
      attempt();
      assumed[j] = Assumed::given;
    }
    assumed[i] = Assumed::given;
  }
  return found;
}

}  // namespace

std::optional<Solution> solve_mixture(const System& s, const Mixture& mixture) {
  const std::vector<Maximum> all = maxima(s, mixture);
  if (all.empty()) return std::nullopt;
  // Each has the integral of its normal distribution.
  std::vector<double> weight;
  for (const Maximum& m : all)
    weight.push_back(m.log_likelihood + 0.5 * std::log(m.covariance.determinant()));
  const double most = *std::max_element(weight.begin(), weight.end());
  double sum = 0.0;
  for (double& w : weight) sum += w = std::exp(w - most);
  Solution solution;
  solution.step = Eigen::VectorXd::Zero(s.unknowns());
  solution.covariance = Eigen::MatrixXd::Zero(s.unknowns(), s.unknowns());
  for (std::size_t k = 0; k < all.size(); ++k) solution.step += weight[k] / sum * all[k].x;
  for (std::size_t k = 0; k < all.size(); ++k) {
    const Eigen::VectorXd off = all[k].x - solution.step;
    solution.covariance +=
        weight[k] / sum * (mixture.variance_factor * all[k].covariance + off * off.transpose());
  }
  solution.residual.resize(s.measurements());
  solution.weight.resize(s.measurements());
  solution.redundancy = -s.unknowns() + s.rows() - s.measurements();
  for (int i = 0; i < s.measurements(); ++i) {
    const double r = residual(s, solution.step, i);
    const Term t(mixture, static_cast<std::size_t>(i), r);
    const double sigma = mixture.direct_sigma[static_cast<std::size_t>(i)];
    solution.residual[i] = r;
    solution.weight[i] = t.direct >= 0.5 ? t.direct : 0.0;
    if (t.direct < 0.5) continue;
    ++solution.redundancy;
    solution.chi_square += r * r / (sigma * sigma);
  }
  return solution;
}

}  // namespace wayfare::robust
