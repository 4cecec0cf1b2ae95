#pragma once

// The navigation filter over a whole drive, one individual per lane, compiled for several
// instruction sets. Its input is plain numbers: with other compile options Eigen's types may have
// another alignment.

#include <wayfare/core/detail/isa.hpp>

namespace wayfare::fitness_kernels {

inline constexpr int kGenes = 33;
inline constexpr int kScores = 6;  ///< north, east, down (m), roll, pitch, yaw (rad)

struct Satellite {
  double position_ecef_m[3], velocity_ecef_mps[3];
  double range_m, range_rate_mps, range_sigma_m, range_rate_sigma_mps;
  bool has_range, has_rate;
};

/// True state of the unit at the end of a step.
struct Truth {
  double offset_m[3];  ///< on the step's plane
  double q_nb[4];      ///< w x y z
  bool has_level, has_heading;
};

/// A prediction, the epoch measured at its end, and the truth there.
struct Step {
  double begin_rate[3], end_rate[3], begin_force[3], end_force[3];
  double dt_s;
  double vibration[3];  ///< sample-to-sample variance of the gyros, (rad/s)²
  int first_satellite, satellites;
  int truth;  ///< index; −1: not scored here
  int plane;  ///< index of the anchor its positions are on
};

struct Anchor {
  double latitude_rad, longitude_rad, height_m;
};

struct Problem {
  const Step* steps;
  int step_count;
  double nominal_dt_s;
  const Satellite* satellites;
  const Truth* truths;
  const Anchor* anchors;
  double start_offset_m[3], start_velocity_mps[3], start_q_nb[4];
  double q_body_imu[4];  ///< w x y z
  double position_sigma_m, velocity_sigma_mps, level_sigma_rad, heading_sigma_rad;
  double clock_bias_m, clock_drift_mps, clock_sigma_m, clock_drift_sigma_mps;
  double lever_imu_m[3];
  double gate_sigma, vibration_share;
};

struct Kernel {
  int lanes;
  /// `genes` are kGenes rows and `rmse` kScores rows of as many columns as there are lanes; a lane
  /// that diverges scores infinity.
  void (*evaluate)(const Problem& problem, const double* genes, double* rmse);
};

[[nodiscard]] const Kernel& kernel_for(Isa isa);

}  // namespace wayfare::fitness_kernels
