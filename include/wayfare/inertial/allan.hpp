#pragma once

// Which random errors a sensor at rest has, from how much means over ever longer times differ:
// IEEE Std 952-1997, annex C; Riley and Howe 2008 (NIST SP 1065).

// A first-order Gauss-Markov process found in a long record by its autocorrelation (Gelb 1974,
// section 2.5).

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace wayfare {

/// Deviation at one averaging time, in the unit of the readings.
struct AllanPoint {
  double tau_s = 0.0;
  double deviation = 0.0;
  /// Standard deviation of `deviation` over itself: 1/√(2(n − 1)) for n averaging times in the
  /// record (IEEE 952, (C.20)), which for overlapping averages errs to the safe side.
  double relative_sigma = 0.0;
};
using AllanCurve = std::vector<AllanPoint>;

/// Takes readings one by one and keeps a few kilobytes for each doubling of the record's length.
/// Averages overlap in every reading up to 64 readings, then in steps of at most 1/32 of the
/// averaging time, which costs no more than a few per cent of what full overlap would tell.
class AllanRecorder {
 public:
  /// `period_s` between readings, which are evenly spaced.
  explicit AllanRecorder(double period_s);

  /// A value that is not finite is left out, as if the record had not got it.
  void add(double value);
  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] double mean() const;

  /// Allan deviation: of first differences of means.
  [[nodiscard]] AllanCurve allan() const { return curve(false); }
  /// Hadamard deviation: of second differences, blind to a constant drift. Equal to the former for
  /// white noise.
  [[nodiscard]] AllanCurve hadamard() const { return curve(true); }

 private:
  /// Squared differences of the running sum at one number of steps.
  struct Sums {
    int steps = 0;
    double allan = 0.0, hadamard = 0.0;
    std::size_t allan_count = 0, hadamard_count = 0;
  };
  static constexpr std::size_t kRing = 256;
  /// The running sum after every 2^level readings.
  struct Level {
    std::array<double, kRing> sum{};
    std::size_t count = 0;
    std::vector<Sums> sums;
  };
  void take(std::size_t level, double sum);
  [[nodiscard]] AllanCurve curve(bool hadamard) const;

  double period_s_;
  std::size_t count_ = 0;
  double first_ = 0.0;
  double sum_ = 0.0, lost_ = 0.0;  ///< of readings less the first; what rounding dropped
  std::vector<Level> levels_;
};

/// A coefficient, and its standard deviation; zero where the curve shows none of it.
struct AllanCoefficient {
  double value = 0.0;
  double sigma = 0.0;
  /// Averaging times at which this error makes up at least a third of the variance; zero: none.
  double from_s = 0.0, to_s = 0.0;
};

/// Parts of an Allan variance: 3Q²/τ² + N²/τ + (2 ln 2/π)B² + K²τ/3. Units follow the readings': of
/// a gyro in rad/s they are rad, rad/√s, rad/s and rad/s/√s.
struct AllanFit {
  AllanCoefficient quantisation;        ///< Q
  AllanCoefficient random_walk;         ///< N: of angle or velocity, white noise of the readings
  AllanCoefficient bias_instability;    ///< B: flicker noise
  AllanCoefficient rate_random_walk;    ///< K
  double floor = 0.0, floor_tau_s = 0;  ///< the lowest point over √(2 ln 2/π), and where
};

/// Least squares on the variance relative to itself (each point by its own spread and 3 % of what
/// no such sum explains), no part negative. Averages that fit into the
/// record fewer than `least_averages` times are left out. Of fewer than three points nothing.
[[nodiscard]] AllanFit fit_allan(std::span<const AllanPoint> curve, double least_averages = 9.0);

/// R(t) = σ² e^(−t/τ) of what is slow in a record; `found` is false where its autocorrelation does
/// not fall off within the record.
struct GaussMarkovFit {
  bool found = false;
  double sigma = 0.0, tau_s = 0.0;
  /// Standard deviations, by how the lags of such a process scatter (Bartlett 1946).
  double sigma_sigma = 0.0, tau_sigma_s = 0.0;
};

/// Takes readings one by one; keeps means of blocks that double in length as the record grows.
class AutocorrelationRecorder {
 public:
  /// `period_s` between readings, which are evenly spaced; at most `blocks` means are kept.
  explicit AutocorrelationRecorder(double period_s, std::size_t blocks = 32768);

  /// A value that is not finite is left out.
  void add(double value);

  /// Of the block means about their own mean, one each block_s().
  [[nodiscard]] std::vector<double> autocorrelation(std::size_t lags) const;
  [[nodiscard]] double block_s() const { return period_s_ * static_cast<double>(length_); }

  /// Generalised least squares on the lags after the first (white noise lives at lag zero alone) up
  /// to where the correlation has fallen to a quarter. That the record's own mean is taken off,
  /// which lowers every lag, is part of the model.
  [[nodiscard]] GaussMarkovFit fit() const;

 private:
  void close_block();

  double period_s_;
  std::size_t most_;
  std::size_t length_ = 1;  ///< readings a block
  std::size_t in_block_ = 0;
  double first_ = 0.0, block_sum_ = 0.0;
  bool started_ = false;
  std::vector<double> means_;
};

}  // namespace wayfare
