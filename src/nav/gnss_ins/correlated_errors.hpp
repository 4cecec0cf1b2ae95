#pragma once

// Correlated errors of measurements, estimated beside the state of a filter.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/manifold.hpp>
#include <wayfare/filter/smoother.hpp>

namespace wayfare::nav {

/// Gauss-Markov errors of measurements with their covariance and that of them and the errors of
/// the state of an Ekf, whose Recorder it is: together they are the covariance of one filter of all
/// (augmented state: Gelb 1974, section 4.5). Their number changes with the measurements.
template <Manifold M>
class CorrelatedErrors : public TapeRecorder<M> {
  using Base = TapeRecorder<M>;
  static constexpr int kDof = ManifoldTraits<M>::kDof;

 public:
  /// What a measurement contains of an error, whose standard deviation is `sigma` now.
  struct Part {
    int key;
    double factor, sigma;
  };
  /// The noise of a measurement by its correlated errors.
  struct Noise {
    double mean, variance;
    TangentOf<M> cross;  ///< with the errors of the state
  };

  [[nodiscard]] std::size_t size() const { return errors_.size(); }

  /// All errors keep the factor `kept` of themselves, and what is lost is renewed. Those that were
  /// not measured for long end.
  void advance(double kept) {
    mean_ *= kept;
    cross_ *= kept;
    own_ *= kept * kept;
    for (std::size_t i = 0; i < errors_.size(); ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      ErrorOf& e = errors_[i];
      const double renewed = (1.0 - kept * kept) * e.measured_variance;
      own_(k, k) += renewed;
      e.variance = kept * kept * e.variance + renewed;
      e.remembered *= kept;
    }
    for (std::size_t i = errors_.size(); i-- > 0;)
      if (errors_[i].remembered < kForgotten) remove(i);
  }

  /// Until `release` the updates of the Ekf are by a measurement that contains these errors.
  Noise measure(std::span<const Part> parts) {
    for (const Part& p : parts) index_of(p);
    measured_.setZero(mean_.size());
    for (const Part& p : parts) measured_[index_of(p)] += p.factor;
    const Eigen::VectorXd of_own = own_ * measured_;
    return {measured_.dot(mean_), measured_.dot(of_own), cross_ * measured_};
  }
  void release() { measured_.setZero(mean_.size()); }

  /// As of Ekf.
  void scale_sigma(int first, int count, double factor) {
    if (errors_.empty()) return;
    cross_.middleRows(first, count) *= factor;
  }

  template <class Step>
  void predicted(const Step& step) {
    Base::predicted(step);
    if (errors_.empty()) return;
    if constexpr (requires { step.phi(); })
      cross_ = (step.phi() * cross_).eval();
    else
      cross_ = (step.phi * cross_).eval();
  }
  template <class Rows, class Gain, class Inverse, class Innovation>
  void updated(const Rows& rows, const Gain& gain, const Inverse& inverse,
               const Innovation& innovation) {
    Base::updated(rows, gain, inverse, innovation);
    if (errors_.empty()) return;
    // The covariance of the innovation and the errors.
    constexpr int n = Inverse::RowsAtCompileTime;
    Seen<n> seen = times<n>(rows);
    seen.rowwise() += (own_ * measured_).transpose();
    const Eigen::Matrix<double, Eigen::Dynamic, n> own_gain = seen.transpose() * inverse;
    mean_ += own_gain * innovation;
    own_ -= own_gain * seen;
    cross_ -= gain * seen;
  }
  void reset(int i) {
    Base::reset(i);
    if (errors_.empty()) return;
    cross_.row(i).setZero();
  }

 private:
  static constexpr double kForgotten = 0.05;
  template <int N>
  using Seen = Eigen::Matrix<double, N, Eigen::Dynamic, N == 1 ? Eigen::RowMajor : Eigen::ColMajor>;

  struct ErrorOf {
    int key;
    double measured_variance;  ///< by the last measurement
    double variance;           ///< without measurements
    double remembered;         ///< of its value when it was last measured
  };

  /// Of an error, a new one if needed. A larger variance than before is that of a further error; a
  /// smaller one takes effect as the error is renewed: what becomes of its value is unknown.
  Eigen::Index index_of(const Part& part) {
    const double variance = part.sigma * part.sigma;
    for (std::size_t i = 0; i < errors_.size(); ++i) {
      ErrorOf& e = errors_[i];
      if (e.key != part.key) continue;
      const auto k = static_cast<Eigen::Index>(i);
      const double further = std::max(variance - e.variance, 0.0);
      own_(k, k) += further;
      e.variance += further;
      e.measured_variance = variance;
      e.remembered = 1.0;
      return k;
    }
    const Eigen::Index n = mean_.size();
    mean_.conservativeResizeLike(Eigen::VectorXd::Zero(n + 1));
    own_.conservativeResizeLike(Eigen::MatrixXd::Zero(n + 1, n + 1));
    cross_.conservativeResizeLike(Cross::Zero(kDof, n + 1));
    measured_.setZero(n + 1);
    own_(n, n) = variance;
    errors_.push_back({part.key, variance, variance, 1.0});
    return n;
  }

  /// The last takes its place.
  void remove(std::size_t i) {
    const auto k = static_cast<Eigen::Index>(i), last = mean_.size() - 1;
    mean_[k] = mean_[last];
    own_.row(k) = own_.row(last).eval();
    own_.col(k) = own_.col(last).eval();
    cross_.col(k) = cross_.col(last).eval();
    mean_.conservativeResize(last);
    own_.conservativeResize(last, last);
    cross_.conservativeResize(kDof, last);
    measured_.setZero(last);
    errors_[i] = errors_.back();
    errors_.pop_back();
  }

  template <int N, class Rows>
  [[nodiscard]] Seen<N> times(const Rows& rows) const {
    if constexpr (requires { rows.index; }) {
      Seen<N> sum = Seen<N>::Zero(N, cross_.cols());
      for (std::size_t k = 0; k < rows.index.size(); ++k) {
        if constexpr (N == 1)
          sum += rows.value[k] * cross_.row(rows.index[k]);
        else
          sum += rows.value.col(static_cast<int>(k)) * cross_.row(rows.index[k]);
      }
      return sum;
    } else {
      return rows * cross_;
    }
  }

  using Cross = Eigen::Matrix<double, kDof, Eigen::Dynamic>;
  std::vector<ErrorOf> errors_;
  Eigen::VectorXd mean_, measured_;
  Eigen::MatrixXd own_;
  Cross cross_ = Cross::Zero(kDof, 0);
};

}  // namespace wayfare::nav
