#pragma once

// Updates by ranges and fixes whose errors are correlated in time, and by outliers.

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>

#include <Eigen/Core>

#include <wayfare/filter/gate.hpp>
#include <wayfare/nav/gnss_ins.hpp>

#include "nav/gnss_ins/receiver_clocks.hpp"

namespace wayfare::nav {

template <class Filter>
class GnssErrors {
 public:
  using Update = typename Filter::Update;
  using State = typename Filter::State;

  explicit GnssErrors(const GnssInsOptions& options)
      : correlated_(options.correlated), gate_{options.gate_sigma, options.robust_sigma} {}

  /// Of the time and path since the last call.
  void advance(Filter& filter, LogTime now) {
    if (correlated_.share <= 0.0) return;
    const double dt = last_ ? std::max(to_seconds(now - *last_), 0.0) : 0.0;
    const double path_m = dt * filter.state().velocity_mps.norm();
    filter.ekf().recorder().advance(
        std::exp(-dt / correlated_.tau_s - path_m / correlated_.distance_m));
    last_ = now;
  }

  Update update_range(Filter& filter, const CorrectedRange& s, double sigma_m,
                      int clock_offset) const {
    if (correlated_.share <= 0.0)
      return update(filter, filter.range_model(s, sigma_m, clock_offset));
    const int key = 256 * static_cast<int>(s.satellite.system) + s.satellite.number;
    const std::array parts{Part{key, 1.0, std::sqrt(correlated_.share) * sigma_m}};
    return update(filter, filter.range_model(s, white() * sigma_m, clock_offset), parts);
  }

  Update update_range_rate(Filter& filter, const CorrectedRange& s, double sigma) const {
    return update(filter, filter.range_rate_model(s, sigma));
  }

  /// A position along `axis` of a fix of this covariance; `model` has the variance along it.
  template <class Model>
  Update update_fix(Filter& filter, Model model, const Eigen::Vector3d& axis,
                    const Eigen::Matrix3d& covariance) const {
    if (correlated_.share <= 0.0) return update(filter, model);
    model.variance *= white() * white();
    std::array<Part, 3> parts;
    for (int i = 0; i < 3; ++i)
      parts[static_cast<std::size_t>(i)] = {
          -1 - i, axis[i], std::sqrt(correlated_.share * std::max(covariance(i, i), 1e-12))};
    return update(filter, model, parts);
  }

  /// A measurement of white noise.
  template <class Model>
  Update update(Filter& filter, const Model& model) const {
    if (gate_.robust_sigma <= 0.0) return filter.ekf().update(model, gate_.gate_sigma);
    return filter.ekf().update_correlated(model, TangentOf<State>::Zero(), gate_);
  }

 private:
  using Errors = CorrelatedErrors<State>;
  using Part = typename Errors::Part;

  /// Rejects or weighs, by the normalised innovation.
  struct Gate {
    double gate_sigma, robust_sigma;
    double operator()(const Innovation<double, 1>& i) const {
      if (!(i.nis <= gate_sigma * gate_sigma)) return 0.0;
      const double limit = robust_sigma * robust_sigma;
      return limit > 0.0 && i.nis > limit ? limit / i.nis : 1.0;
    }
  };

  [[nodiscard]] double white() const { return std::sqrt(std::max(1.0 - correlated_.share, 1e-6)); }

  template <class Model>
  Update update(Filter& filter, const Model& model, std::span<const Part> parts) const {
    Errors& errors = filter.ekf().recorder();
    const typename Errors::Noise noise = errors.measure(parts);
    const auto with_errors = [&](const State& x) {
      auto m = model(x);
      m.innovation -= noise.mean;
      m.variance += noise.variance;
      return m;
    };
    const auto result = filter.ekf().update_correlated(with_errors, noise.cross, gate_);
    errors.release();
    return result;
  }

  CorrelatedErrorOptions correlated_;
  Gate gate_;
  std::optional<LogTime> last_;
};

}  // namespace wayfare::nav
