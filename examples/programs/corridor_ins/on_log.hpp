#pragma once

// The corridor filter on a recorded log.

#include <functional>
#include <span>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/nav/corridor_ins.hpp>
#include <wayfare/nav/travel_direction.hpp>
#include <wayfare/sensors/recording.hpp>

#include "support/option_fields.hpp"

namespace wayfare::examples {

/// For logs of unknown lasers and wheels; without gyro, the yaw rate is that of the odometry.
[[nodiscard]] CorridorInsOptions corridor_options_for_logs(bool has_gyro);
/// The same for what a log has, with its laser.
[[nodiscard]] CorridorInsOptions corridor_options_of(const Recording& recording);

/// The options of --config.
[[nodiscard]] std::vector<OptionField> corridor_option_fields(CorridorInsOptions& options);

/// What tells forward from backward.
enum class DirectionFrom {
  automatic,  ///< the scans if the wheels never count backwards, else the wheels
  wheels,
  scans
};

/// The motion of a log.
[[nodiscard]] SignedMotion signed_motion_of(const Recording& recording,
                                            DirectionFrom from = DirectionFrom::automatic);

/// Several passes over the log, each with the bias of the last: the result then does not depend on
/// the initial bias error.
[[nodiscard]] Result<CorridorRun> run_corridor_passes(const Recording& recording,
                                                      std::span<const MotionSample> motion,
                                                      CorridorInsOptions options, int passes,
                                                      const std::function<void(double)>& progress);

}  // namespace wayfare::examples
