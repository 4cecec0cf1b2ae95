#pragma once

#include <string>

#include <wayfare/core/result.hpp>
#include <wayfare/system/graph_slam.hpp>

namespace wayfare::examples {

/// Options from a JSON object whose keys are the fields' names (angles end in `_deg`); what it does
/// not name keeps its default. Errors: not JSON, an unknown key, a value out of range.
[[nodiscard]] Result<GraphSlamOptions> read_config(const std::string& path);

/// Every option with its default, as such a file.
[[nodiscard]] std::string default_config();

}  // namespace wayfare::examples
