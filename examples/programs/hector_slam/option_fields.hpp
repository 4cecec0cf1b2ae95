#pragma once

#include <vector>

#include <wayfare/slam/hector_slam.hpp>

#include "support/option_fields.hpp"

namespace wayfare::examples {

/// The options of a JSON file.
[[nodiscard]] std::vector<OptionField> hector_slam_fields(HectorSlamOptions& options);

}  // namespace wayfare::examples
