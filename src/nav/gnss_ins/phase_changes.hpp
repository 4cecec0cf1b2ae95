#pragma once

// Changes of carrier phases between epochs: pairs of phases, cycle slips, updates.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include <wayfare/filter/sequential_update.hpp>
#include <wayfare/gnss/phase_displacement.hpp>
#include <wayfare/nav/gnss_ins.hpp>

#include "nav/gnss_ins/receiver_clocks.hpp"

namespace wayfare::nav {

/// The earlier epoch of a filter with EarlierAntenna.
template <class Filter>
class PhaseChanges {
 public:
  PhaseChanges(const ReceiverClockNoise& clock, const CarrierPhaseOptions& options)
      : options_(options), clock_walk_(clock.bias_walk_m_per_sqrt_s) {}

  /// The next epoch is compared with none before it.
  void forget() { earlier_.reset(); }

  /// Updates by the changes since the earlier epoch. Calls record(satellite, ScalarUpdate) of each.
  template <class Record>
  void update(Filter& filter, const RangeEpoch& epoch, const Record& record) {
    if (!earlier_) return;
    const double dt_s = to_seconds(epoch.time - earlier_->time);
    if (!(dt_s > 0.0) || dt_s > options_.longest_interval_s) return;
    std::vector<PhasePair> pairs = phase_pairs(*earlier_, epoch);
    drop_slips(filter, pairs, dt_s, record);
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
      if (std::isfinite(s.phase_m)) earlier_->satellites.push_back(s);
    if (earlier_->satellites.empty()) return forget();
    filter.ekf().predict(
        CloneAntenna<double, kOffsets>{filter.plane(), filter.clock_anchor_m(), filter.lever_m()});
  }

 private:
  /// By the range rates.
  template <class Record>
  void drop_slips(const Filter& filter, std::vector<PhasePair>& pairs, double dt_s,
                  const Record& record) const {
    const std::vector<PhasePair> all = pairs;
    const std::vector<SatelliteId> slipped = drop_slips_by_rates(
        pairs, dt_s, clock_walk_ * std::sqrt(dt_s), filter.state().earlier.template head<3>());
    for (const PhasePair& pair : all) {
      if (std::find(slipped.begin(), slipped.end(), pair.after->satellite) == slipped.end())
        continue;
      const auto m = model(filter, pair)(filter.state());
      const double sigma = filter.ekf().predicted_sigma(m);
      record(pair.after->satellite, ScalarUpdate<double>{m.innovation, sigma * sigma, false});
    }
  }

  [[nodiscard]] PhaseChangeModel<double, kOffsets> model(const Filter& filter,
                                                         const PhasePair& pair) const {
    CorrectedRange now = *pair.after;
    now.range_m = now.phase_m;
    const double sigma = options_.sigma_scale * pair.sigma_m();
    return {filter.range_model(now, sigma), pair.before->position_ecef_m, pair.before->phase_m,
            sigma * sigma};
  }

  CarrierPhaseOptions options_;
  double clock_walk_;
  std::optional<RangeEpoch> earlier_;
};

}  // namespace wayfare::nav
