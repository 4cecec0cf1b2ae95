#pragma once

#include <vector>

#include <wayfare/slam/submap_slam.hpp>

#include "option_fields.hpp"

namespace wayfare::examples {

/// Every option a JSON file may set, by name.
[[nodiscard]] std::vector<OptionField> submap_slam_fields(SubmapSlamOptions& options);

/// What each field's own range does not say.
[[nodiscard]] Result<void> check_submap_slam(const SubmapSlamOptions& options);

}  // namespace wayfare::examples
