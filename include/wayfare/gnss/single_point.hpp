#pragma once

// Position, velocity and time of a receiver from one epoch, by least squares that find and leave
// out faulty satellites.

#include <array>
#include <limits>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/result.hpp>
#include <wayfare/gnss/correct_ranges.hpp>
#include <wayfare/sensors/gnss.hpp>

namespace wayfare {

/// What a receiver's clock shows more against one system than against another, m: the systems'
/// own difference and the receiver's delays.
struct ClockOffset {
  double offset_m = 0.0;
  double sigma_m = 0.0;
};

struct SinglePointOptions {
  RangeCorrectionOptions corrections;
  /// Looks for satellites whose ranges do not go with the others' and leaves them out.
  bool exclude_faults = true;
  /// How often ranges that follow their standard deviations may be taken for faulty.
  double false_alarm = 1e-3;
  /// Where the robust loss turns from a square to a logarithm, σ.
  double robust_scale = 2.0;
  /// Satellites whose residuals are larger than this in the robust solution are left out, σ.
  double exclusion_sigma = 5.0;
  /// What to do where the satellites left still disagree: an answer whose covariance is as large as
  /// its residuals say and whose `consistent` is false, or an error.
  bool answer_inconsistent = true;
  /// A geometry worse than this gives no answer.
  double max_pdop = 30.0;
  /// Another system's clock against GPS's where that is known beforehand (see SystemOffsets): m and
  /// its standard deviation, by system. Each is worth one satellite.
  std::array<std::optional<ClockOffset>, kGnssSystems> offsets = {};
};

/// Dilutions of precision: geometry (with clocks), position, horizontal, vertical, and time of the
/// first system's clock.
struct DilutionOfPrecision {
  double geometry = 0.0, position = 0.0, horizontal = 0.0, vertical = 0.0, time = 0.0;
};

/// What one satellite had to do with the solution.
struct SatelliteResidual {
  SatelliteId satellite;
  LineOfSight sight;
  double range_m = std::numeric_limits<double>::quiet_NaN();  ///< measured − computed
  double range_sigma_m = 0.0;
  double rate_mps = std::numeric_limits<double>::quiet_NaN();
  double rate_sigma_mps = 0.0;
  double cn0_dbhz = std::numeric_limits<double>::quiet_NaN();
  bool range_used = false;
  bool rate_used = false;
};

struct SinglePoint {
  LogTime time;     ///< as the receiver's clock read
  LogTime instant;  ///< when that was: `time` less the clock's bias against the first system used
  Eigen::Vector3d position_ecef_m = Eigen::Vector3d::Zero();
  Geodetic position;
  Eigen::Matrix3d position_covariance_ned_m2 = Eigen::Matrix3d::Zero();
  /// Absent where too few Doppler measurements agree.
  std::optional<Eigen::Vector3d> velocity_ned_mps;
  Eigen::Matrix3d velocity_covariance_ned = Eigen::Matrix3d::Zero();
  /// Receiver clock against each system's, m; NaN for systems without a used satellite.
  std::array<double, kGnssSystems> clock_bias_m = {
      std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::quiet_NaN(),
      std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::quiet_NaN()};
  double clock_drift_mps = std::numeric_limits<double>::quiet_NaN();
  DilutionOfPrecision dop;
  int used = 0;
  int degrees_of_freedom = 0;
  /// Sum of squared residuals over their variances, of the satellites used.
  double chi_square = 0.0;
  /// The satellites used agree. Without a degree of freedom nothing was there to disagree.
  bool consistent = true;
  std::vector<SatelliteResidual> residuals;
  std::vector<RefusedRange> refused;
};

/// Iterated weighted least squares for position and one clock a system (Kaplan and Hegarty 2017,
/// 11.2). Where the sum of squares fails its χ² test (Parkinson and Axelrad 1988) a robust solution
/// takes its place: the loss Σ ln(1 + (r / (scale · σ))²), minimised by reweighting from the best
/// of the solutions without none, each one and each two of the satellites; what is far from it is
/// left out. `near_ecef_m` may be left at zero.
///
/// Errors: `degenerate` where there are too few satellites (the message says how many, and of which
/// systems) or their geometry is too poor; `numerical` where iteration does not end; `invalid`
/// where the satellites disagree and an answer to that is not wanted.
[[nodiscard]] Result<SinglePoint> single_point(
    const RangeEpoch& epoch, const SinglePointOptions& options = {},
    const Eigen::Vector3d& near_ecef_m = Eigen::Vector3d::Zero());

/// The same from raw observations, which are corrected anew as the position becomes known.
[[nodiscard]] Result<SinglePoint> single_point(
    const ObservationEpoch& epoch, const Ephemerides& ephemerides,
    const SinglePointOptions& options = {},
    const Eigen::Vector3d& near_ecef_m = Eigen::Vector3d::Zero());

/// The value a χ² variable of `degrees_of_freedom` exceeds with probability `probability`, by
/// Wilson and Hilferty's approximation (1931), good to 3 % down to one degree of freedom.
[[nodiscard]] double chi_square_threshold(int degrees_of_freedom, double probability);

/// Learns from solutions what the systems' clocks differ by, so that in a street with few
/// satellites a second system need not spend one on its own clock. An exponential mean with
/// outliers held back.
class SystemOffsets {
 public:
  /// Takes the clocks of a consistent solution; others are passed over. It should have been made
  /// without known offsets, or they confirm themselves.
  void learn(const SinglePoint& point);
  /// What is known, against GPS; nothing before ten solutions.
  [[nodiscard]] std::optional<ClockOffset> of(GnssSystem system) const;
  [[nodiscard]] std::array<std::optional<ClockOffset>, kGnssSystems> all() const;

 private:
  struct Track {
    int count = 0;
    double mean_m = 0.0;
    double spread_m = 0.0;  ///< mean absolute deviation
  };
  std::array<Track, kGnssSystems> tracks_;
};

/// Brings the ranges of all systems to GPS's clock, for a filter with one receiver clock. Ranges of
/// systems whose offset is not known lose their range and keep their rate; the offset's uncertainty
/// goes into the others' standard deviations.
[[nodiscard]] RangeEpoch on_one_clock(const RangeEpoch& epoch, const SystemOffsets& offsets);

/// The solution as a fix for a loosely coupled filter.
[[nodiscard]] GnssFix to_fix(const SinglePoint& point);

}  // namespace wayfare
