#pragma once

// How well the navigation filter does over a drive with known truth, for many sets of parameters at
// once (Zhang 2020, figure 3.2): as many filters as a register holds run side by side, on the
// widest instruction set the processor has.

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

namespace wayfare {

/// A drive to tune on.
struct TuningDrive {
  std::vector<ImuSample> imu;
  std::vector<RangeEpoch> ranges;  ///< of one clock: offsets between systems are taken out
  /// Of the unit; nothing where the reference does not reach.
  std::function<std::optional<NavState>(LogTime)> truth;
  bool has_level = true, has_heading = true;  ///< what of the truth's attitude is known
  GnssInsOptions options;                     ///< mounting, lever arm, gate and time offset
  GnssInsStart start;
};

/// Root mean square errors; angles in degrees.
struct InsRmse {
  double north_m = 0.0, east_m = 0.0, down_m = 0.0;
  double roll_deg = 0.0, pitch_deg = 0.0, heading_deg = 0.0;
};

/// What each counts in the weighted sum that is the fitness; heading most.
struct InsFitnessWeights {
  double north = 1.0, east = 1.0, down = 1.0;
  double roll = 1.0, pitch = 1.0, heading = 2.0;

  [[nodiscard]] double sum(const InsRmse& e) const;
};

struct InsFitnessOptions {
  InsFitnessWeights weights;
  double score_interval_s = 0.2;  ///< between comparisons with the truth
  int threads = 1;                ///< no result depends on it
  /// "avx512", "avx2", "baseline"; empty: the widest that runs here. No result depends on it.
  std::string kernel;
};

/// Copies share the drive, which does not change: cheap, and safe from several threads.
///
/// The filter is that of the navigation system with one receiver clock, without constraints,
/// without standstill, and without doubt in itself: whoever refuses all measurements is lost and
/// scores badly. Lanes do not touch each other, and every kernel rounds alike: a set of parameters
/// scores the same to the last bit whatever its neighbours, the instruction set and the number of
/// threads.
class InsFitness {
 public:
  /// Errors: no readings or epochs after the start, no truth to compare with, an unknown kernel or
  /// one this processor does not run.
  [[nodiscard]] static Result<InsFitness> make(const TuningDrive& drive,
                                               const InsFitnessOptions& options = {});

  /// Rows of kInsGenes in, one score each out; infinity for whoever diverges.
  void operator()(std::span<const double> individuals, std::span<double> scores,
                  const std::function<void(double)>& progress = {}) const;
  [[nodiscard]] std::vector<InsRmse> rmse(std::span<const double> individuals,
                                          const std::function<void(double)>& progress = {}) const;

  [[nodiscard]] std::string kernel() const;  ///< its name
  [[nodiscard]] int lanes() const;
  [[nodiscard]] double length_s() const;
  [[nodiscard]] std::size_t steps() const;

 private:
  struct Content;
  std::shared_ptr<const Content> content_;
};

}  // namespace wayfare
