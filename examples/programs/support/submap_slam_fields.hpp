#pragma once

#include <vector>

#include <wayfare/slam/submap_slam.hpp>

#include "option_fields.hpp"

namespace wayfare::examples {

/// The options of a JSON file.
[[nodiscard]] std::vector<OptionField> submap_slam_fields(SubmapSlamOptions& options);

/// Conditions beyond the range of each field.
[[nodiscard]] Result<void> check_grid(const MultiResolutionOptions& grid);
}  // namespace wayfare::examples
