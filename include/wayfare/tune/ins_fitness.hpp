#pragma once

// The 33 tuned parameters of the navigation filter, in the order of Zhang 2020, table 2: σ and τ of
// gyro bias, gyro scale, accelerometer bias and accelerometer scale (three axes each), white noise
// of gyros and accelerometers, random walks of the clock's bias and drift, scale of the ranges'
// standard deviations.
//
// Accuracy of the navigation filter over a drive with known truth, for many parameter sets at once
// (Zhang 2020, figure 3.2): one filter per SIMD lane, on the widest available instruction set.

#include <array>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/nav/gnss_ins.hpp>
#include <wayfare/tune/genetic.hpp>

namespace wayfare {

/// 4 × 2 × 3 of the processes, 2 × 3 white noises, 3 of the receiver.
inline constexpr std::size_t kInsGenes = 33;

/// Largest ratio of a parameter to its nominal value and vice versa.
struct InsGeneSpans {
  double noise = 30.0;        ///< standard deviations and white noises
  double tau = 30.0;          ///< correlation times
  double clock = 30.0;        ///< random walks of the receiver clock
  double range_scale = 10.0;  ///< factor of the ranges' standard deviations
};

/// The 33 parameters of these options, in the order above.
[[nodiscard]] std::vector<double> ins_genes(const GnssInsOptions& options);
/// `options` with these 33 parameters replaced.
[[nodiscard]] GnssInsOptions with_ins_genes(const GnssInsOptions& options,
                                            std::span<const double> genes);
/// Logarithmic bounds around the nominal parameters.
[[nodiscard]] std::vector<Gene> ins_gene_bounds(const GnssInsOptions& nominal,
                                                const InsGeneSpans& spans = {});

/// A drive to tune on.
struct TuningDrive {
  std::vector<ImuSample> imu;      ///< readings of the unit, in order of time
  std::vector<RangeEpoch> ranges;  ///< of one clock: inter-system offsets removed
  /// True state of the unit; none outside the reference.
  std::function<std::optional<NavState>(LogTime)> truth;
  bool has_level = true,   ///< roll and pitch of the truth are known
      has_heading = true;  ///< its heading is known
  GnssInsOptions options;  ///< mounting, lever arm, gate and time offset
  GnssInsStart start;      ///< initial state of the filter and its uncertainty
};

/// Root mean square errors; angles in degrees.
struct InsRmse {
  double north_m = 0.0,   ///< towards north
      east_m = 0.0,       ///< towards east
      down_m = 0.0;       ///< down
  double roll_deg = 0.0,  ///< about the axis forward
      pitch_deg = 0.0,    ///< to the right
      heading_deg = 0.0;  ///< about the vertical
};

/// Weights of the errors in the fitness; heading has the largest.
struct InsFitnessWeights {
  double north = 1.0,  ///< of the error in m
      east = 1.0,      ///< of the error in m
      down = 1.0;      ///< of the error in m
  double roll = 1.0,   ///< of the error in degrees
      pitch = 1.0,     ///< of the error in degrees
      heading = 2.0;   ///< of the error in degrees

  /// The weighted sum of the errors: the score, lower is better.
  [[nodiscard]] double sum(const InsRmse& e) const;
};

/// How a drive is scored.
struct InsFitnessOptions {
  InsFitnessWeights weights;      ///< of the errors in the score
  double score_interval_s = 0.2;  ///< between comparisons with the truth
  int threads = 1;                ///< does not change results
  /// "avx512", "avx2", "baseline"; empty: the widest available. Does not change results.
  std::string kernel;
  /// Propagates the covariance at every reading, as the navigation system does, in place of once for all
  /// readings between two epochs: scores agree to a millionth, and it takes two to three times as long.
  bool covariance_every_step = false;
};

/// Copies share the immutable drive: cheap and thread-safe.
///
/// The filter is that of the navigation system with one receiver clock, without constraints,
/// zero-velocity updates and covariance inflation: a filter that rejects all measurements diverges
/// and scores badly. Lanes are independent and every kernel rounds identically: scores are
/// bit-identical for any neighbours, instruction set and number of threads.
class InsFitness {
 public:
  /// Errors: no readings or epochs after the start, no truth, an unknown or unsupported kernel, a
  /// score interval or time offset that is not a number.
  [[nodiscard]] static Result<InsFitness> make(const TuningDrive& drive,
                                               const InsFitnessOptions& options = {});

  /// One score per row of kInsGenes; infinity on divergence.
  void operator()(std::span<const double> individuals, std::span<double> scores,
                  const std::function<void(double)>& progress = {}) const;
  /// Errors of each row of kInsGenes over the drive, in their own units.
  [[nodiscard]] std::vector<InsRmse> rmse(std::span<const double> individuals,
                                          const std::function<void(double)>& progress = {}) const;

  [[nodiscard]] std::string kernel() const;  ///< its name

 private:
  struct Content;
  std::shared_ptr<const Content> content_;
};

}  // namespace wayfare
