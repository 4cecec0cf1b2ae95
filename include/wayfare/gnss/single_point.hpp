#pragma once

// Position, velocity and time from one epoch by least squares with fault exclusion.

#include <array>
#include <limits>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/result.hpp>
#include <wayfare/gnss/correct_ranges.hpp>
#include <wayfare/sensors/measurements.hpp>

namespace wayfare {

/// Inter-system clock offset of a receiver, m: difference of the system times and of the receiver's
/// delays.
struct ClockOffset {
  double offset_m = 0.0;  ///< system − GPS
  double sigma_m = 0.0;   ///< standard deviation
};

/// Signals that arrive by reflections alone, as between houses: their ranges are longer. Each range
/// is direct or reflected, with a probability that increases as C/N0 decreases.
struct ReflectionModel {
  /// σ of a direct range; without the reflections that the weights of all ranges allow for.
  RangeSigmaModel direct = {3.0, 0.5, 1.5, 0.03, 0.02, 0.06, 35.0};
  double odds_at_45_dbhz = 0.06;  ///< of a reflected against a direct range
  double decrease_dbhz = 5.0;     ///< of C/N0 for e times the odds
  double excess_m = 30.0,         ///< mean by which a reflected range is longer
      excess_sigma_m = 30.0;      ///< its standard deviation
  /// Of the covariance: reflections of several satellites by one house are not independent.
  double variance_factor = 1.5;
};

/// Corrections, tests and limits of single_point.
struct SinglePointOptions {
  RangeCorrectionOptions corrections;  ///< of raw observations
  /// Detects and excludes satellites with inconsistent ranges.
  bool exclude_faults = true;
  /// False alarm probability of the χ² test.
  double false_alarm = 1e-3;
  /// Scale at which the robust loss changes from quadratic to logarithmic, σ.
  double robust_scale = 2.0;
  /// Satellites with larger residuals in the robust solution are excluded, σ.
  double exclusion_sigma = 5.0;
  /// If the remaining satellites disagree: returns a solution with `consistent` false and a
  /// covariance scaled by its residuals, or else an error.
  bool answer_inconsistent = true;
  /// With it, the mean and covariance over the hypotheses of which ranges are reflected, in place
  /// of fault exclusion. A solution is then `consistent` if its horizontal protection level is
  /// within `alert_limit_m`.
  std::optional<ReflectionModel> reflections = {};
  double alert_limit_m = 40.0;  ///< see `reflections`
  /// Probability with which an error may exceed its protection level.
  double integrity_risk = 1e-5;
  /// Above this PDOP there is no solution.
  double max_pdop = 30.0;
  /// Known clock offsets of other systems to GPS (see SystemOffsets), by system. Each replaces one
  /// satellite.
  std::array<std::optional<ClockOffset>, kGnssSystems> offsets = {};
};

/// Dilutions of precision: geometry (with clocks), position, horizontal, vertical, and time of the
/// first system's clock.
struct DilutionOfPrecision {
  double geometry = 0.0,  ///< with clocks
      position = 0.0,     ///< three dimensions
      horizontal = 0.0,   ///< north and east
      vertical = 0.0,     ///< down
      time = 0.0;         ///< first clock
};

/// One satellite's part in the solution.
struct SatelliteResidual {
  SatelliteId satellite;                                       ///< of the epoch
  LineOfSight sight;                                           ///< its direction
  double range_m = std::numeric_limits<double>::quiet_NaN();   ///< measured − computed
  double range_sigma_m = 0.0;                                  ///< standard deviation
  double rate_mps = std::numeric_limits<double>::quiet_NaN();  ///< measured − computed
  double rate_sigma_mps = 0.0;                                 ///< standard deviation
  double cn0_dbhz = std::numeric_limits<double>::quiet_NaN();  ///< carrier-to-noise density
  /// Not excluded; with a ReflectionModel, more probably direct than reflected.
  bool range_used = false;
  bool rate_used = false;  ///< not excluded
};

/// Position, velocity and clocks of one epoch, with the tests behind them.
struct SinglePoint {
  LogTime time;     ///< of the receiver's clock
  LogTime instant;  ///< true time: `time` less the clock bias to the first system used
  Eigen::Vector3d position_ecef_m = Eigen::Vector3d::Zero();             ///< of the antenna
  Geodetic position;                                                     ///< of the antenna, WGS-84
  Eigen::Matrix3d position_covariance_ned_m2 = Eigen::Matrix3d::Zero();  ///< m²
  /// Protection levels: errors exceed them with SinglePointOptions::integrity_risk, or less, if
  /// they are normally distributed with the covariance.
  double horizontal_protection_m = 0.0,  ///< of north and east
      vertical_protection_m = 0.0;       ///< of down
  /// None if too few Doppler measurements agree.
  std::optional<Eigen::Vector3d> velocity_ned_mps;
  Eigen::Matrix3d velocity_covariance_ned = Eigen::Matrix3d::Zero();  ///< (m/s)²
  /// Receiver clock bias to each system, m; NaN for systems without a used satellite.
  std::array<double, kGnssSystems> clock_bias_m = {
      std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::quiet_NaN(),
      std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::quiet_NaN()};
  double clock_drift_mps = std::numeric_limits<double>::quiet_NaN();  ///< of the receiver clock
  DilutionOfPrecision dop;                                            ///< of the ranges used
  int used = 0;                                                       ///< number of ranges
  int degrees_of_freedom = 0;  ///< of the ranges: used, less the unknowns
  /// Sum of squared normalised residuals of the satellites used.
  double chi_square = 0.0;
  /// The satellites used agree; true without a degree of freedom. With a ReflectionModel: the
  /// protection level is within the alert limit.
  bool consistent = true;
  std::vector<SatelliteResidual> residuals;  ///< of every satellite with a range or rate
  std::vector<RefusedRange> refused;         ///< with the first reason found
};

/// Iterated weighted least squares for position and one clock per system (Kaplan and Hegarty 2017,
/// 11.2). If the sum of squares fails its χ² test (Parkinson and Axelrad 1988) a robust solution
/// replaces it: the loss Σ ln(1 + (r / (scale · σ))²), minimised by iterative reweighting from the
/// best of the solutions with up to two satellites removed; outliers to it are excluded. With a
/// ReflectionModel the likelihood is a mixture for each range, and the solution the mean of its
/// local maxima, each a normal distribution, with the covariance within and between them (Gaussian
/// sum: Alspach and Sorenson 1972); the maxima are found by expectation maximisation from the
/// solutions with up to two satellites removed, or, without two ranges to spare and with up to
/// eight, under every hypothesis.
/// `near_ecef_m` may be zero; beyond 10⁹ m, or not finite, it is ignored. Of a satellite's ranges
/// and of its rates in one epoch the first counts.
///
/// Errors: `degenerate` for too few satellites (the message gives the number by system) or a poor
/// geometry; `numerical` if the iteration does not converge; `invalid` if the satellites disagree
/// and `answer_inconsistent` is false.
[[nodiscard]] Result<SinglePoint> single_point(
    const RangeEpoch& epoch, const SinglePointOptions& options = {},
    const Eigen::Vector3d& near_ecef_m = Eigen::Vector3d::Zero());

/// The same from raw observations, with iterated range corrections.
[[nodiscard]] Result<SinglePoint> single_point(
    const ObservationEpoch& epoch, const Ephemerides& ephemerides,
    const SinglePointOptions& options = {},
    const Eigen::Vector3d& near_ecef_m = Eigen::Vector3d::Zero());

/// The value a χ² variable of `degrees_of_freedom` exceeds with probability `probability`, by
/// Wilson and Hilferty's approximation (1931), good to 3 % down to one degree of freedom; zero
/// without one.
[[nodiscard]] double chi_square_threshold(int degrees_of_freedom, double probability);

/// Estimates inter-system clock offsets from solutions, so that with few satellites a second system
/// does not need one for its own clock. An exponential mean with clipped outliers.
class SystemOffsets {
 public:
  /// Uses the clocks of consistent solutions only. They must be computed without known offsets.
  void learn(const SinglePoint& point);
  /// The offset to GPS; none before ten solutions.
  [[nodiscard]] std::optional<ClockOffset> of(GnssSystem system) const;
  /// By system, as of().
  [[nodiscard]] std::array<std::optional<ClockOffset>, kGnssSystems> all() const;

 private:
  struct Track {
    int count = 0;
    double mean_m = 0.0;
    double spread_m = 0.0;  ///< mean absolute deviation
  };
  std::array<Track, kGnssSystems> tracks_;
};

/// Converts the ranges of all systems to the GPS clock, for a filter with one receiver clock.
/// Systems with unknown offset lose their ranges and keep their rates; the others' standard
/// deviations include that of the offset.
[[nodiscard]] RangeEpoch on_one_clock(const RangeEpoch& epoch, const SystemOffsets& offsets);

/// The solution as a fix for a loosely coupled filter.
[[nodiscard]] GnssFix to_fix(const SinglePoint& point);

}  // namespace wayfare
