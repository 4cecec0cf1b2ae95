#pragma once

// Errors of the corridor system against the truth.

#include <array>
#include <functional>
#include <string>
#include <vector>

#include <wayfare/nav/corridor_ins.hpp>
#include <wayfare/sim/worlds.hpp>

namespace wayfare::examples {

/// How the walls are used.
enum class Aiding { none, scan_to_scan, side_walls, end_walls, marks };
[[nodiscard]] const char* name_of(Aiding aiding);

/// For a simulated drive, with the noise of the simulator.
[[nodiscard]] CorridorInsOptions options_for(const sim::CorridorDriveParams& params, Aiding aiding);

/// Initial pose of the filter: the origin, which is true, with errors of its initial sigmas.
[[nodiscard]] SE2d start_of(const CorridorInsOptions& options, const Rng& rng);

/// Errors of one run; sections in the order of sim::CorridorSection, the last entry is the total.
struct CorridorErrors {
  std::array<double, 6> position_rmse_m{};
  double heading_rmse_deg = 0.0;
  double end_m = 0.0;
  double bias_error_deg_s = 0.0;  ///< at the end, estimate minus truth
  double bias_sigma_deg_s = 0.0;
  double scale_error = 0.0, scale_sigma = 0.0;
  double along_sigma_m = 0.0, across_sigma_m = 0.0;  ///< of the last corridor, at the end
  std::vector<double> nees;  ///< of (x, y, heading, bias, scale) at every tenth scan in motion
  double walls_share = 0.0;  ///< of the scans
};

/// While the vehicle moves, after `rest_s`.
[[nodiscard]] CorridorErrors errors_of(const CorridorRun& run, const sim::CorridorDrive& drive,
                                       double rest_s);

/// True gyro bias, rad/s.
[[nodiscard]] double true_bias_at(const sim::CorridorDrive& drive, LogTime time);

}  // namespace wayfare::examples
