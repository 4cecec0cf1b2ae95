#pragma once

// Changes of carrier phases between epochs: pairs of phases, cycle slips, updates.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <wayfare/core/statistics.hpp>
#include <wayfare/filter/sequential_update.hpp>
#include <wayfare/nav/gnss_ins.hpp>

#include "nav/gnss_ins/receiver_clocks.hpp"

namespace wayfare::nav {

[[nodiscard]] inline bool has_phase(const CorrectedRange& s) {
  return std::abs(s.phase_m) < 1e12 && s.position_ecef_m.squaredNorm() < 1e20 &&
         is_usable_sigma(s.phase_sigma_m);
}

/// One satellite's phases at two epochs.
struct PhasePair {
  const CorrectedRange *before, *after;
};

/// Satellites whose phases at both epochs belong together, as far as the receiver says.
[[nodiscard]] inline std::vector<PhasePair> phase_pairs(const RangeEpoch& before,
                                                        const RangeEpoch& after) {
  std::vector<PhasePair> pairs;
  for (const CorrectedRange& s : after.satellites) {
    if (!has_phase(s) || s.phase_interrupted) continue;
    const auto same = std::find_if(before.satellites.begin(), before.satellites.end(),
                                   [&](const auto& b) { return b.satellite == s.satellite; });
    if (same != before.satellites.end() && has_phase(*same)) pairs.push_back({&*same, &s});
  }
  return pairs;
}

/// Removes pairs whose phase changes by something else than the integral of the range rates, as far
/// as these tell: `dt_s` between the epochs; the receiver's clock changes by an unknown common part
/// that is about `clock_m`.
inline void drop_slips_by_rates(std::vector<PhasePair>& pairs, double dt_s, double clock_m) {
  // The trapezoidal rule is wrong by a twelfth of the jerk times the third power of the time.
  constexpr double kJerk_mps3 = 10.0, kSigmas = 5.0;
  const auto excess = [dt_s](const PhasePair& p) {
    return p.after->phase_m - p.before->phase_m -
           0.5 * dt_s * (p.after->range_rate_mps + p.before->range_rate_mps);
  };
  std::vector<double> all;
  for (const PhasePair& p : pairs)
    if (std::isfinite(excess(p))) all.push_back(excess(p));
  const bool common = all.size() >= 4;
  const double shift = common ? upper_median_of(all) : 0.0;
  std::erase_if(pairs, [&](const PhasePair& p) {
    const double rate =
        0.5 * dt_s * std::hypot(p.after->range_rate_sigma_mps, p.before->range_rate_sigma_mps);
    const double limit =
        kSigmas * std::hypot(rate, p.after->phase_sigma_m, common ? 0.0 : clock_m) +
        kJerk_mps3 * dt_s * dt_s * dt_s / 12.0;
    return std::abs(excess(p) - shift) > limit;
  });
}

/// Innovations ν with covariance S, of which those are removed, one by one, that the prediction and
/// all others contradict: |(S⁻¹ν)ᵢ| / √(S⁻¹)ᵢᵢ is the error of a prediction of νᵢ by all others in
/// its standard deviations. Returns which stay.
[[nodiscard]] inline std::vector<bool> consistent_innovations(const Eigen::VectorXd& nu,
                                                              const Eigen::MatrixXd& s,
                                                              double limit) {
  std::vector<bool> stays(static_cast<std::size_t>(nu.size()), true);
  std::vector<Eigen::Index> left(static_cast<std::size_t>(nu.size()));
  for (std::size_t i = 0; i < left.size(); ++i) left[i] = static_cast<Eigen::Index>(i);
  while (!left.empty()) {
    const auto n = static_cast<Eigen::Index>(left.size());
    const Eigen::LDLT<Eigen::MatrixXd> solver(Eigen::MatrixXd(s(left, left)));
    const Eigen::VectorXd weighted = solver.solve(Eigen::VectorXd(nu(left)));
    const Eigen::VectorXd inverse =
        solver.solve(Eigen::MatrixXd::Identity(n, n)).diagonal().cwiseMax(1e-300);
    Eigen::Index worst = 0;
    const double most = (weighted.cwiseAbs().array() / inverse.array().sqrt()).maxCoeff(&worst);
    if (most <= limit) break;
    stays[static_cast<std::size_t>(left[static_cast<std::size_t>(worst)])] = false;
    left.erase(left.begin() + worst);
  }
  return stays;
}

/// The earlier epoch of a filter with EarlierAntenna.
template <class Filter>
class PhaseChanges {
 public:
  explicit PhaseChanges(const GnssInsOptions& options)
      : options_(options.carrier_phase.value_or(CarrierPhaseOptions{})),
        clock_walk_(options.clock.bias_walk_m_per_sqrt_s) {}

  /// The next epoch is compared with none before it.
  void forget() { earlier_.reset(); }

  /// Updates by the changes since the earlier epoch. Calls record(satellite, ScalarUpdate) of each.
  template <class Record>
  void update(Filter& filter, const RangeEpoch& epoch, const Record& record) {
    if (!earlier_) return;
    const double dt_s = to_seconds(epoch.time - earlier_->time);
    if (!(dt_s > 0.0) || dt_s > options_.longest_interval_s) return;
    std::vector<PhasePair> pairs = phase_pairs(*earlier_, epoch);
    drop_slips_by_rates(pairs, dt_s, clock_walk_ * std::sqrt(dt_s));
    const auto n = static_cast<Eigen::Index>(pairs.size());
    constexpr int kDof = Filter::kDof;
    Eigen::Matrix<double, kDof, Eigen::Dynamic> h =
        Eigen::Matrix<double, kDof, Eigen::Dynamic>::Zero(kDof, n);
    Eigen::VectorXd nu(n), noise(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const auto m = model(filter, pairs[static_cast<std::size_t>(i)])(filter.state());
      for (std::size_t k = 0; k < m.row.index.size(); ++k) h(m.row.index[k], i) += m.row.value[k];
      nu[i] = m.innovation, noise[i] = m.variance;
    }
    Eigen::MatrixXd s = h.transpose() * filter.covariance() * h;
    s.diagonal() += noise;
    const std::vector<bool> stays = consistent_innovations(nu, s, options_.gate_sigma);
    for (Eigen::Index i = 0; i < n; ++i) {
      const PhasePair& pair = pairs[static_cast<std::size_t>(i)];
      const auto refused = ScalarUpdate<double>{nu[i], s(i, i), false};
      record(pair.after->satellite, stays[static_cast<std::size_t>(i)]
                                        ? filter.ekf().update(model(filter, pair))
                                        : refused);
    }
  }

  /// The next epoch is compared with this one, at which the filter is now.
  void keep(Filter& filter, const RangeEpoch& epoch) {
    earlier_.emplace(RangeEpoch{epoch.time, {}});
    for (const CorrectedRange& s : epoch.satellites)
      if (has_phase(s)) earlier_->satellites.push_back(s);
    if (earlier_->satellites.empty()) return forget();
    filter.ekf().predict(
        CloneAntenna<double, kOffsets>{filter.plane(), filter.clock_anchor_m(), filter.lever_m()});
  }

 private:
  [[nodiscard]] PhaseChangeModel<double, kOffsets> model(const Filter& filter,
                                                         const PhasePair& pair) const {
    CorrectedRange now = *pair.after;
    now.range_m = now.phase_m;
    const double sigma =
        options_.sigma_scale * std::hypot(pair.before->phase_sigma_m, pair.after->phase_sigma_m);
    return {filter.range_model(now, sigma), pair.before->position_ecef_m, pair.before->phase_m,
            sigma * sigma};
  }

  CarrierPhaseOptions options_;
  double clock_walk_;
  std::optional<RangeEpoch> earlier_;
};

}  // namespace wayfare::nav
