#include <wayfare/gnss/phase_displacement.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include <Eigen/Cholesky>

#include <wayfare/core/statistics.hpp>

namespace wayfare {
namespace {

bool has_phase(const CorrectedRange& s) {
  return std::abs(s.phase_m) < 1e12 && s.position_ecef_m.squaredNorm() < 1e20 &&
         s.phase_sigma_m > 1e-6 && s.phase_sigma_m < 1e9;
}

/// Rows of unknown displacement and clock, the measured changes without the satellites' motion, and
/// their variances.
struct Equations {
  Eigen::MatrixX4d rows;
  Eigen::VectorXd changes, variances;
};

Equations equations_of(const std::vector<PhasePair>& pairs, const Eigen::Vector3d& before_ecef_m) {
  const auto n = static_cast<Eigen::Index>(pairs.size());
  Equations e{Eigen::MatrixX4d(n, 4), Eigen::VectorXd(n), Eigen::VectorXd(n)};
  for (Eigen::Index i = 0; i < n; ++i) {
    const PhasePair& p = pairs[static_cast<std::size_t>(i)];
    const Eigen::Vector3d first = p.before->position_ecef_m - before_ecef_m;
    const Eigen::Vector3d second = p.after->position_ecef_m - before_ecef_m;
    e.rows.row(i) << -second.normalized().transpose(), 1.0;
    e.changes[i] = p.change_m() - (second.norm() - first.norm());
    e.variances[i] = p.sigma_m() * p.sigma_m();
  }
  return e;
}

/// Which equations agree, whatever the displacement.
std::vector<bool> consistent(const Equations& e, double gate_sigma) {
  // A displacement and a clock change of this size are nothing unusual.
  constexpr double kAny_m2 = 1e6;
  std::vector<double> all(e.changes.begin(), e.changes.end());
  const double clock = upper_median_of(all);
  Eigen::MatrixXd s = kAny_m2 * e.rows * e.rows.transpose();
  s.diagonal() += e.variances;
  return consistent_innovations(e.changes.array() - clock, s, gate_sigma);
}

}  // namespace

double PhasePair::sigma_m() const {
  return std::hypot(before->phase_sigma_m, after->phase_sigma_m);
}

std::vector<PhasePair> phase_pairs(const RangeEpoch& before, const RangeEpoch& after) {
  std::vector<PhasePair> pairs;
  for (const CorrectedRange& s : after.satellites) {
    if (!has_phase(s) || s.phase_interrupted) continue;
    const auto same = std::find_if(before.satellites.begin(), before.satellites.end(),
                                   [&](const auto& b) { return b.satellite == s.satellite; });
    if (same != before.satellites.end() && has_phase(*same)) pairs.push_back({&*same, &s});
  }
  return pairs;
}

std::vector<SatelliteId> drop_slips_by_rates(std::vector<PhasePair>& pairs, double dt_s,
                                             double clock_sigma_m,
                                             const Eigen::Vector3d& near_ecef_m) {
  constexpr double kJerk_mps3 = 4.0, kSigmas = 5.0;
  const double path_m = kJerk_mps3 * dt_s * dt_s * dt_s / 12.0;
  std::vector<PhasePair> kept, judged;
  for (const PhasePair& p : pairs) {
    const bool rates =
        std::isfinite(p.after->range_rate_mps) && std::isfinite(p.before->range_rate_mps);
    (rates ? judged : kept).push_back(p);
  }
  const auto n = static_cast<Eigen::Index>(judged.size());
  Eigen::MatrixX3d sight(n, 3);
  Eigen::VectorXd excess(n), variances(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const PhasePair& p = judged[static_cast<std::size_t>(i)];
    sight.row(i) = (p.after->position_ecef_m - near_ecef_m).normalized().transpose();
    excess[i] = p.change_m() - 0.5 * dt_s * (p.after->range_rate_mps + p.before->range_rate_mps);
    const double rates =
        0.5 * dt_s * std::hypot(p.after->range_rate_sigma_mps, p.before->range_rate_sigma_mps);
    variances[i] = rates * rates + p.sigma_m() * p.sigma_m();
  }
  Eigen::MatrixXd s = path_m * path_m * sight * sight.transpose();
  s.array() += clock_sigma_m * clock_sigma_m;
  s.diagonal() += variances;
  const std::vector<bool> stays = consistent_innovations(excess, s, kSigmas);
  std::vector<SatelliteId> slipped;
  for (std::size_t i = 0; i < judged.size(); ++i) {
    if (stays[i])
      kept.push_back(judged[i]);
    else
      slipped.push_back(judged[i].after->satellite);
  }
  pairs = std::move(kept);
  return slipped;
}

std::vector<bool> consistent_innovations(const Eigen::VectorXd& innovations,
                                         const Eigen::MatrixXd& covariance, double limit) {
  const auto count = static_cast<std::size_t>(innovations.size());
  std::vector<bool> stays(count, true);
  std::vector<Eigen::Index> left(count);
  for (std::size_t i = 0; i < count; ++i) left[i] = static_cast<Eigen::Index>(i);
  while (!left.empty()) {
    const auto n = static_cast<Eigen::Index>(left.size());
    const Eigen::LDLT<Eigen::MatrixXd> solver(Eigen::MatrixXd(covariance(left, left)));
    const Eigen::VectorXd weighted = solver.solve(Eigen::VectorXd(innovations(left)));
    const Eigen::MatrixXd inverse = solver.solve(Eigen::MatrixXd::Identity(n, n));
    const Eigen::ArrayXd size =
        weighted.cwiseAbs().array() / inverse.diagonal().cwiseMax(1e-300).array().sqrt();
    // Written so that NaN is removed.
    const auto worst = std::max_element(size.begin(), size.end(),
                                        [](double a, double b) { return a < b || std::isnan(b); });
    if (*worst <= limit) break;
    const auto at = worst - size.begin();
    stays[static_cast<std::size_t>(left[static_cast<std::size_t>(at)])] = false;
    left.erase(left.begin() + at);
  }
  return stays;
}

std::optional<PhaseDisplacement> phase_displacement(const RangeEpoch& before,
                                                    const RangeEpoch& after,
                                                    const Eigen::Vector3d& before_ecef_m,
                                                    double gate_sigma) {
  const double dt_s = to_seconds(after.time - before.time);
  if (!(dt_s > 0.0) || !before_ecef_m.allFinite()) return std::nullopt;
  PhaseDisplacement result;
  std::vector<PhasePair> pairs = phase_pairs(before, after);
  if (pairs.size() < 4) return std::nullopt;
  // The receiver's clock may jump by milliseconds.
  constexpr double kAnyClock_m = 1e6;
  result.slipped = drop_slips_by_rates(pairs, dt_s, kAnyClock_m, before_ecef_m);
  if (pairs.size() < 4) return std::nullopt;
  const std::vector<bool> stays = consistent(equations_of(pairs, before_ecef_m), gate_sigma);
  std::vector<PhasePair> kept;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    (stays[i] ? result.used : result.slipped).push_back(pairs[i].after->satellite);
    if (stays[i]) kept.push_back(pairs[i]);
  }
  if (kept.size() < (kept.size() < pairs.size() ? 5U : 4U)) return std::nullopt;
  // The direction to the satellite is that from the new position; two rounds suffice.
  Eigen::Vector4d x = Eigen::Vector4d::Zero();
  Equations e = equations_of(kept, before_ecef_m);
  for (int round = 0; round < 3; ++round) {
    Eigen::VectorXd residuals(e.changes.size());
    for (Eigen::Index i = 0; i < residuals.size(); ++i) {
      const PhasePair& p = kept[static_cast<std::size_t>(i)];
      const Eigen::Vector3d line = p.after->position_ecef_m - before_ecef_m - x.head<3>();
      e.rows.row(i).head<3>() = -line.normalized().transpose();
      residuals[i] =
          p.change_m() - (line.norm() - (p.before->position_ecef_m - before_ecef_m).norm()) - x[3];
    }
    const Eigen::MatrixX4d weighted = e.variances.cwiseInverse().asDiagonal() * e.rows;
    const Eigen::LLT<Eigen::Matrix4d> normal(Eigen::Matrix4d(e.rows.transpose() * weighted));
    if (normal.info() != Eigen::Success) return std::nullopt;
    x += normal.solve(weighted.transpose() * residuals);
    result.covariance = normal.solve(Eigen::Matrix4d::Identity());
  }
  if (!x.allFinite() || !result.covariance.allFinite()) return std::nullopt;
  result.displacement_ecef_m = x.head<3>();
  result.clock_m = x[3];
  return result;
}

}  // namespace wayfare
