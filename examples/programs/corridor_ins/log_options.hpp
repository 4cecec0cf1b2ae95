#pragma once

#include <vector>

#include <wayfare/nav/corridor_ins.hpp>

#include "support/option_fields.hpp"

namespace wayfare::examples {

/// For logs of unknown lasers and wheels; without gyro, the yaw rate is that of the odometry.
[[nodiscard]] CorridorInsOptions log_defaults(bool has_gyro);

/// The options of --config.
[[nodiscard]] std::vector<OptionField> corridor_option_fields(CorridorInsOptions& o);

}  // namespace wayfare::examples
