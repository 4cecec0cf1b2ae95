#include <wayfare/inertial/imu_noise.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/LU>

#include <wayfare/core/contract.hpp>

namespace wayfare {

AutocorrelationRecorder::AutocorrelationRecorder(double period_s, std::size_t blocks)
    : period_s_(period_s), max_blocks_(blocks - blocks % 2) {
  WAYFARE_EXPECTS(period_s > 0.0 && blocks >= 16, "a positive period and at least 16 blocks");
}

void AutocorrelationRecorder::add(double value) {
  if (!(std::abs(value) <= 1e100)) return;  // sums of squares would overflow
  if (!started_) first_ = value;
  started_ = true;
  block_sum_ += value - first_;
  if (++in_block_ == length_) close_block();
}

void AutocorrelationRecorder::close_block() {
  means_.push_back(block_sum_ / static_cast<double>(length_));
  block_sum_ = 0.0;
  in_block_ = 0;
  if (means_.size() < max_blocks_) return;
  for (std::size_t i = 0; i < means_.size() / 2; ++i)
    means_[i] = 0.5 * (means_[2 * i] + means_[2 * i + 1]);
  means_.resize(means_.size() / 2);
  length_ *= 2;
}

namespace {

double mean_of(const std::vector<double>& x) {
  double sum = 0.0;
  for (const double v : x) sum += v;
  return sum / static_cast<double>(x.size());
}

double correlation(const std::vector<double>& x, double mean, std::size_t lag) {
  double sum = 0.0;
  for (std::size_t i = lag; i < x.size(); ++i) sum += (x[i] - mean) * (x[i - lag] - mean);
  return sum / static_cast<double>(x.size() - lag);
}

/// R(t) of means over blocks of length d, for unit variance, less the bias from subtracting the
/// mean over `length`.
double model(double t, double tau, double d, double length) {
  const double half = 0.5 * d / tau, u = length / tau;
  const double smoothing = half < 1e-4 ? 1.0 : std::sinh(half) / half;
  const double mean_variance = 2.0 / u * (1.0 - (1.0 - std::exp(-u)) / u);
  return smoothing * smoothing * std::exp(-t / tau) - mean_variance;
}

}  // namespace

std::vector<double> AutocorrelationRecorder::autocorrelation(std::size_t lags) const {
  std::vector<double> r;
  if (means_.empty()) return r;
  const double mean = mean_of(means_);
  for (std::size_t lag = 0; lag < std::min(lags, means_.size()); ++lag)
    r.push_back(correlation(means_, mean, lag));
  return r;
}

namespace {

/// Lags in increasing steps, until the correlation has fallen to a quarter.
struct Lags {
  std::vector<std::size_t> lag;
  Eigen::VectorXd value;
  bool fell = false;
};

Lags early_lags(const std::vector<double>& means, double mean) {
  Lags lags;
  std::vector<double> values;
  double first = 0.0, recent = 0.0;
  for (std::size_t lag = 1; lag < means.size() / 2 && !lags.fell; lag += 1 + lag / 8) {
    values.push_back(correlation(means, mean, lag));
    lags.lag.push_back(lag);
    recent = values.size() == 1 ? values[0] : recent + 0.5 * (values.back() - recent);
    if (values.size() <= 4) first += (values.back() - first) / static_cast<double>(values.size());
    lags.fell = values.size() >= 5 && recent < 0.25 * first;
  }
  lags.fell = lags.fell && first > 0.0;
  lags.value = Eigen::Map<const Eigen::VectorXd>(values.data(), std::ssize(values));
  return lags;
}

/// Generalised least squares on the lags with their covariance by Bartlett 1946, n·cov(R(i), R(j))
/// = Σ R(k) R(k + j − i) + R(k) R(k + j + i), for R(k) = σ² ρ^|k| + w at zero.
class LagFit {
 public:
  LagFit(const Lags& lags, double block_s, std::size_t blocks, double at_zero)
      : lags_(lags), block_s_(block_s), blocks_(static_cast<double>(blocks)), at_zero_(at_zero) {
    weight_.setIdentity(lags.value.size(), lags.value.size());
  }

  [[nodiscard]] Eigen::VectorXd shape(double tau) const {
    Eigen::VectorXd m(lags_.value.size());
    for (Eigen::Index i = 0; i < m.size(); ++i)
      m[i] = model(block_s_ * static_cast<double>(lags_.lag[static_cast<std::size_t>(i)]), tau,
                   block_s_, block_s_ * blocks_);
    return m;
  }
  /// The best σ² for a given τ, in closed form.
  [[nodiscard]] double variance(double tau) const {
    const Eigen::VectorXd m = shape(tau), wm = weight_ * m;
    return wm.dot(lags_.value) / wm.dot(m);
  }
  /// Golden-section search over the logarithm.
  [[nodiscard]] double best_tau() const {
    const auto cost = [this](double log_tau) {
      const double tau = std::exp(log_tau);
      const Eigen::VectorXd e = lags_.value - variance(tau) * shape(tau);
      return e.dot(weight_ * e);
    };
    constexpr double kGolden = std::numbers::phi - 1.0;
    double low = std::log(0.3 * block_s_), high = std::log(0.5 * block_s_ * blocks_);
    for (int i = 0; i < 60; ++i) {
      const double a = high - kGolden * (high - low), b = low + kGolden * (high - low);
      const bool left = cost(a) < cost(b);
      (left ? high : low) = left ? b : a;
    }
    return std::exp(0.5 * (low + high));
  }
  void weigh_by(double tau, double variance) {
    const double rho = std::exp(-block_s_ / tau), white = std::max(0.0, at_zero_ - variance);
    const auto products = [&](double h) {
      const double slow = variance * std::pow(rho, h);
      return variance * slow * (h + (1.0 + rho * rho) / (1.0 - rho * rho)) + 2.0 * white * slow +
             (h == 0.0 ? white * white : 0.0);
    };
    Eigen::MatrixXd c(lags_.value.size(), lags_.value.size());
    for (Eigen::Index i = 0; i < c.rows(); ++i) {
      for (Eigen::Index j = 0; j < c.cols(); ++j) {
        const auto a = static_cast<double>(lags_.lag[static_cast<std::size_t>(i)]);
        const auto b = static_cast<double>(lags_.lag[static_cast<std::size_t>(j)]);
        c(i, j) = (products(std::abs(b - a)) + products(a + b)) / blocks_;
      }
    }
    // A model error keeps precisely known lags from dominating the others.
    constexpr double kLagModelError = 0.05;
    c.diagonal().array() += kLagModelError * kLagModelError * variance * variance;
    weight_ = c.ldlt().solve(Eigen::MatrixXd::Identity(c.rows(), c.cols()));
  }
  /// Covariance of σ² and τ, from the model's derivatives.
  [[nodiscard]] Eigen::Matrix2d covariance(double tau, double variance) const {
    Eigen::MatrixXd j(lags_.value.size(), 2);
    j.col(0) = shape(tau);
    const double step = 1e-3 * tau;
    j.col(1) = variance / (2.0 * step) * (shape(tau + step) - shape(tau - step));
    return (j.transpose() * weight_ * j).inverse();
  }

 private:
  const Lags& lags_;
  double block_s_, blocks_, at_zero_;
  Eigen::MatrixXd weight_;
};

}  // namespace

GaussMarkovFit AutocorrelationRecorder::fit() const {
  GaussMarkovFit fit;
  if (means_.size() < 16) return fit;
  const double mean = mean_of(means_);
  const Lags lags = early_lags(means_, mean);
  if (!lags.fell) return fit;
  LagFit search(lags, block_s(), means_.size(), correlation(means_, mean, 0));
  double tau = search.best_tau(), variance = search.variance(tau);
  for (int round = 0; round < 3 && variance > 0.0; ++round) {
    search.weigh_by(tau, variance);
    tau = search.best_tau();
    variance = search.variance(tau);
  }
  const Eigen::Matrix2d c = search.covariance(tau, variance);
  if (!(variance > 0.0) || !(c(0, 0) > 0.0) || !(c(1, 1) > 0.0)) return fit;
  const double sigma = std::sqrt(variance);
  return {true, sigma, tau, 0.5 * std::sqrt(c(0, 0)) / sigma, std::sqrt(c(1, 1))};
}

}  // namespace wayfare
