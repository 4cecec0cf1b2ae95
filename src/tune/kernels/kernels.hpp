#pragma once

// The navigation filter over a whole drive, one individual per lane, compiled for several
// instruction sets. Eigen's alignment depends on the compile options: no types with Eigen's
// quaternions, and of vectors and matrices only those of three rows, which are never aligned.

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/detail/isa.hpp>
#include <wayfare/core/geodesy.hpp>
#include <wayfare/inertial/ins_state.hpp>
#include <wayfare/sensors/measurements.hpp>

namespace wayfare::fitness_kernels {

inline constexpr int kGenes = 33;
inline constexpr std::size_t kMostPanels = 10;  ///< of an interval
inline constexpr int kScores = 6;               ///< north, east, down (m), roll, pitch, yaw (rad)

using Quaternion = std::array<double, 4>;  ///< w x y z

/// True state of the unit at the end of a step.
struct Truth {
  Eigen::Vector3d offset_m;  ///< on the step's plane
  Quaternion q_nb;
  bool has_level, has_heading;
};

/// A prediction, the epoch measured at its end, and the truth there.
struct Step {
  ImuInterval imu;
  Eigen::Vector3d vibration;  ///< sample-to-sample variance of the gyros, (rad/s)²
  std::size_t first_satellite, satellites;
  std::size_t plane;           ///< index of the anchor its positions are on
  std::optional<Truth> truth;  ///< none: not scored here
  /// The covariance is propagated by intervals of steps, the noise of a step at three nodes of its
  /// interval in these shares; a node ends each panel.
  std::size_t first_node;
  std::array<double, 3> shares;
  bool ends_panel, ends_interval;
};
static_assert(alignof(Step) == alignof(double) && alignof(CorrectedRange) == alignof(double));

struct Problem {
  std::vector<Step> steps;
  double nominal_dt_s;
  std::vector<CorrectedRange> satellites;
  std::vector<Geodetic> anchors;
  Eigen::Vector3d start_velocity_mps;
  Quaternion start_q_nb, q_body_imu;
  double position_sigma_m, velocity_sigma_mps, level_sigma_rad, heading_sigma_rad;
  double clock_bias_m, clock_drift_mps, clock_sigma_m, clock_drift_sigma_mps;
  Eigen::Vector3d lever_imu_m;
  double gate_sigma, vibration_share;
  bool by_intervals;  ///< else the covariance is propagated at every step
};

struct Kernel {
  int lanes;
  /// `genes` are kGenes rows and `rmse` kScores rows of as many columns as there are lanes; a lane
  /// that diverges scores infinity.
  void (*evaluate)(const Problem& problem, const double* genes, double* rmse);
};

[[nodiscard]] const Kernel& kernel_for(Isa isa);

}  // namespace wayfare::fitness_kernels
