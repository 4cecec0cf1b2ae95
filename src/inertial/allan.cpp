#include <wayfare/inertial/imu_noise.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <wayfare/core/contract.hpp>

namespace wayfare {
namespace {

// Averaging lengths: dense up to 8, then four per octave.
constexpr std::array kFirstSteps = {1,  2,  3,  4,  5,  6,  7,  8,  10, 11,
                                    13, 16, 19, 23, 27, 32, 38, 45, 54, 64};
constexpr std::array kLaterSteps = {38, 45, 54, 64};

}  // namespace

AllanRecorder::AllanRecorder(double period_s) : period_s_(period_s) {
  WAYFARE_EXPECTS(period_s > 0.0, "the sampling period is positive");
  add_sum(0, 0.0);
}

void AllanRecorder::add(double value) {
  if (!(std::abs(value) <= 1e100)) return;  // sums of squares would overflow
  if (count_ == 0) first_ = value;
  // Kahan summation: days of readings accumulate a large total with small differences.
  const double term = value - first_ - compensation_;
  const double sum = sum_ + term;
  compensation_ = (sum - sum_) - term;
  sum_ = sum;
  ++count_;
  std::size_t level = 0;
  for (std::size_t n = count_;; n /= 2, ++level) {
    add_sum(level, sum_);
    if (n % 2 != 0) break;
  }
}

double AllanRecorder::mean() const {
  return count_ == 0 ? 0.0 : first_ + sum_ / static_cast<double>(count_);
}

void AllanRecorder::add_sum(std::size_t level, double sum) {
  while (levels_.size() <= level) {
    Level next;
    const auto add_steps = [&next](const auto& all) {
      for (const int steps : all) next.sums.push_back({steps, 0.0, 0.0, 0, 0});
    };
    if (levels_.empty()) {
      add_steps(kFirstSteps);
    } else {
      add_steps(kLaterSteps);
      next.count = 1;  // the sum before the first reading, zero
    }
    levels_.push_back(std::move(next));
  }
  Level& l = levels_[level];
  l.sum[l.count % kRing] = sum;
  const auto before = [&l](std::size_t k) { return l.sum[(l.count - k) % kRing]; };
  for (Sums& s : l.sums) {
    const auto m = static_cast<std::size_t>(s.steps);
    if (l.count < 2 * m) break;
    const double d2 = sum - 2.0 * before(m) + before(2 * m);
    s.allan += d2 * d2;
    ++s.allan_count;
    if (l.count < 3 * m) continue;
    const double d3 = sum - 3.0 * before(m) + 3.0 * before(2 * m) - before(3 * m);
    s.hadamard += d3 * d3;
    ++s.hadamard_count;
  }
  ++l.count;
}

AllanCurve AllanRecorder::curve(bool hadamard) const {
  AllanCurve points;
  double readings = 1.0;
  for (const Level& level : levels_) {
    for (const Sums& s : level.sums) {
      const std::size_t n = hadamard ? s.hadamard_count : s.allan_count;
      if (n == 0) break;
      const double m = readings * s.steps;
      const double squares = hadamard ? s.hadamard / 6.0 : s.allan / 2.0;
      const double averages = static_cast<double>(count_) / m;
      points.push_back({m * period_s_, std::sqrt(squares / static_cast<double>(n)) / m,
                        1.0 / std::sqrt(2.0 * (averages - 1.0))});
    }
    readings *= 2.0;
  }
  return points;
}

namespace {

constexpr int kParts = 4;
using Parts = Eigen::Matrix<double, kParts, 1>;
using Normal = Eigen::Matrix<double, kParts, kParts>;
constexpr double kFlicker = 2.0 * std::numbers::ln2 / std::numbers::pi;

/// Contribution of each unit squared coefficient to the variance.
Parts parts_at(double tau) { return {3.0 / (tau * tau), 1.0 / tau, kFlicker, tau / 3.0}; }

struct Solution {
  Parts squares = Parts::Zero();
  Parts sigma = Parts::Zero();
};

/// Relative error of the four-part model: without it, short averaging times, known to a thousandth,
/// distort the fit of long ones.
constexpr double kModelError = 0.03;

/// Equations divided by the expected variance and whitened. Neighbouring averaging times share most
/// readings: the correlation of their errors is modelled as the ratio of the times.
struct Weighted {
  Eigen::Matrix<double, Eigen::Dynamic, kParts> rows;
  Eigen::VectorXd right;
};

Weighted weighted(std::span<const AllanPoint> curve, const Eigen::VectorXd& expected) {
  const auto n = static_cast<Eigen::Index>(curve.size());
  Weighted w{decltype(Weighted::rows)(n, kParts), Eigen::VectorXd(n)};
  Eigen::MatrixXd covariance(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const AllanPoint& p = curve[static_cast<std::size_t>(i)];
    w.rows.row(i) = parts_at(p.tau_s).transpose() / expected[i];
    w.right[i] = p.deviation * p.deviation / expected[i];
    for (Eigen::Index j = 0; j < n; ++j) {
      const AllanPoint& q = curve[static_cast<std::size_t>(j)];
      covariance(i, j) = 4.0 * p.relative_sigma * q.relative_sigma * std::min(p.tau_s, q.tau_s) /
                         std::max(p.tau_s, q.tau_s);
    }
    covariance(i, i) += 4.0 * kModelError * kModelError;
  }
  const Eigen::LLT<Eigen::MatrixXd> root(covariance);
  root.matrixL().solveInPlace(w.rows);
  root.matrixL().solveInPlace(w.right);
  return w;
}

/// Least squares over all subsets of parts whose coefficients are all non-negative.
Parts solve_non_negative(const Weighted& w) {
  Parts best = Parts::Zero();
  double least = w.right.squaredNorm();
  for (unsigned choice = 1; choice < 1U << kParts; ++choice) {
    std::vector<int> used;
    for (int k = 0; k < kParts; ++k)
      if ((choice >> k & 1U) != 0) used.push_back(k);
    const Eigen::MatrixXd a = w.rows(Eigen::all, used);
    // The parts differ by many decades: columns are normalised.
    const Eigen::VectorXd scale = a.colwise().norm();
    const Eigen::MatrixXd scaled = a * scale.cwiseInverse().asDiagonal();
    const Eigen::VectorXd x =
        (scaled.transpose() * scaled).ldlt().solve(scaled.transpose() * w.right);
    if (!x.allFinite() || x.minCoeff() < 0.0) continue;
    const double cost = (scaled * x - w.right).squaredNorm();
    if (cost >= least) continue;
    least = cost;
    best.setZero();
    for (std::size_t k = 0; k < used.size(); ++k)
      best[used[k]] = x[static_cast<Eigen::Index>(k)] / scale[static_cast<Eigen::Index>(k)];
  }
  return best;
}

Parts sigma_of(const Weighted& w, const Parts& squares) {
  std::vector<int> used;
  for (int k = 0; k < kParts; ++k)
    if (squares[k] > 0.0) used.push_back(k);
  Parts sigma = Parts::Zero();
  if (used.empty()) return sigma;
  const Eigen::MatrixXd a = w.rows(Eigen::all, used);
  const Eigen::VectorXd scale = a.colwise().norm();
  const Eigen::MatrixXd scaled = a * scale.cwiseInverse().asDiagonal();
  const Eigen::MatrixXd covariance =
      (scaled.transpose() * scaled)
          .ldlt()
          .solve(Eigen::MatrixXd::Identity(scaled.cols(), scaled.cols()));
  for (std::size_t k = 0; k < used.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    sigma[used[k]] = std::sqrt(std::max(0.0, covariance(i, i))) / scale[i];
  }
  return sigma;
}

Solution solve(std::span<const AllanPoint> curve) {
  Eigen::VectorXd expected(static_cast<Eigen::Index>(curve.size()));
  for (Eigen::Index i = 0; i < expected.size(); ++i) {
    const double d = curve[static_cast<std::size_t>(i)].deviation;
    expected[i] = d * d;
  }
  Solution s;
  // Iteratively reweighted: weights from the curve itself would favour points that are low by
  // chance.
  for (int round = 0; round < 6; ++round) {
    const Weighted w = weighted(curve, expected);
    s.squares = solve_non_negative(w);
    s.sigma = sigma_of(w, s.squares);
    for (Eigen::Index i = 0; i < expected.size(); ++i) {
      const double model = parts_at(curve[static_cast<std::size_t>(i)].tau_s).dot(s.squares);
      if (model > 0.0) expected[i] = model;
    }
  }
  return s;
}

AllanCoefficient coefficient(const Solution& s, int part, std::span<const AllanPoint> curve) {
  AllanCoefficient c;
  c.value = std::sqrt(s.squares[part]);
  if (c.value > 0.0) c.sigma = 0.5 * s.sigma[part] / c.value;
  for (const AllanPoint& p : curve) {
    const Parts at = parts_at(p.tau_s).cwiseProduct(s.squares);
    if (at[part] * 3.0 < at.sum() || at[part] == 0.0) continue;
    if (c.from_s == 0.0) c.from_s = p.tau_s;
    c.to_s = p.tau_s;
  }
  return c;
}

/// Far from where squares and ratios overflow.
bool is_usable(const AllanPoint& p) {
  const auto positive = [](double x) { return x > 1e-30 && x < 1e30; };
  return positive(p.deviation) && positive(p.tau_s) && std::isfinite(p.relative_sigma);
}

}  // namespace

AllanFit fit_allan(std::span<const AllanPoint> curve, double least_averages) {
  AllanCurve used;
  // The fit takes the square of the number of points in memory, and its cube in time.
  const std::size_t step = (curve.size() + 499) / 500;
  for (std::size_t i = 0; i < curve.size(); i += step) {
    const AllanPoint& p = curve[i];
    const double averages = 1.0 + 0.5 / (p.relative_sigma * p.relative_sigma);
    if (averages >= least_averages && is_usable(p)) used.push_back(p);
  }
  AllanFit fit;
  if (used.size() < 3) return fit;
  const Solution s = solve(used);
  fit.quantisation = coefficient(s, 0, used);
  fit.random_walk = coefficient(s, 1, used);
  fit.bias_instability = coefficient(s, 2, used);
  fit.rate_random_walk = coefficient(s, 3, used);
  const auto lowest = std::min_element(used.begin(), used.end(), [](const auto& a, const auto& b) {
    return a.deviation < b.deviation;
  });
  fit.floor = lowest->deviation / std::sqrt(kFlicker);
  fit.floor_tau_s = lowest->tau_s;
  return fit;
}

}  // namespace wayfare
