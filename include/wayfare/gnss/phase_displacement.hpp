#pragma once

// How far an antenna has moved between two epochs, by the change of carrier phases, and which of
// them have slipped. A phase has an unknown constant as long as the receiver tracks the signal;
// differences of two epochs are free of it (van Graas and Soloviev 2004, "Precise velocity
// estimation using a stand-alone GPS receiver").

#include <optional>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/detail/eigen_alignment.hpp>
#include <wayfare/sensors/measurements.hpp>

namespace wayfare {

/// One satellite's phases at two epochs; of epochs that must outlive it.
struct PhasePair {
  const CorrectedRange *before = nullptr,  ///< first epoch
      *after = nullptr;                    ///< second epoch
  /// Change of the phase, m.
  [[nodiscard]] double change_m() const { return after->phase_m - before->phase_m; }
  /// Its standard deviation: the noise of two phases, m.
  [[nodiscard]] double sigma_m() const;
};

/// Satellites whose phase is measured at both epochs, without a loss of lock that the receiver
/// noticed.
[[nodiscard]] std::vector<PhasePair> phase_pairs(const RangeEpoch& before, const RangeEpoch& after);

/// Removes pairs whose change is not the integral of the range rates by the trapezoidal rule, as
/// far as these and all other pairs tell (consistent_innovations). That rule's error, a twelfth of
/// the acceleration's change times the time squared, is an unknown vector; the change of the
/// receiver's clock beyond its drift is common to all and of standard deviation `clock_sigma_m`.
/// `dt_s`: between the epochs; `near_ecef_m`: the receiver, to some kilometres. Returns the
/// satellites removed.
std::vector<SatelliteId> drop_slips_by_rates(std::vector<PhasePair>& pairs, double dt_s,
                                             double clock_sigma_m,
                                             const Eigen::Vector3d& near_ecef_m);

/// Of innovations ν with covariance S, those that agree with the prediction and all others. One by
/// one, the worst is removed while |(S⁻¹ν)ᵢ| / √(S⁻¹)ᵢᵢ exceeds `limit`: that is the error of the
/// prediction of νᵢ by all others, in its standard deviations (Baarda 1968).
[[nodiscard]] std::vector<bool> consistent_innovations(const Eigen::VectorXd& innovations,
                                                       const Eigen::MatrixXd& covariance,
                                                       double limit);

/// Motion of an antenna between two epochs.
struct PhaseDisplacement {
  Eigen::Vector3d displacement_ecef_m = Eigen::Vector3d::Zero();  ///< Earth-fixed
  double clock_m = 0.0;                                           ///< change of the clock's bias
  /// Of displacement and clock, by the phases' standard deviations.
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();
  std::vector<SatelliteId> used,  ///< satellites
      slipped;                    ///< excluded: cycle slips
};

/// Weighted least squares from the change of at least four satellites' phases. `before_ecef_m`: the
/// position at the first epoch; an error of 10 m there is one of about 2 mm for each second between
/// the epochs. None where there are fewer, or where a slip is seen but cannot be attributed to a
/// satellite: that needs six satellites.
[[nodiscard]] std::optional<PhaseDisplacement> phase_displacement(
    const RangeEpoch& before, const RangeEpoch& after, const Eigen::Vector3d& before_ecef_m,
    double gate_sigma = 4.0);

}  // namespace wayfare
