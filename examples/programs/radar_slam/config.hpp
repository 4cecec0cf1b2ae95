#pragma once

// The options of radar_slam's --config.

#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/slam/radar_slam.hpp>
#include <wayfare/sync/augmented_scans.hpp>

#include "support/option_fields.hpp"

namespace wayfare::examples {

struct RadarSlamConfig {
  RadarSlamOptions slam;
  DeadReckoningOptions reckoning;
  SyncParams sync;
};

[[nodiscard]] std::vector<OptionField> fields(RadarSlamConfig& config);

/// Reads the file, if any, and checks the values together.
[[nodiscard]] Result<void> read_config(const std::string& path, RadarSlamConfig& config);

/// Whether a gate rejects matches.
[[nodiscard]] bool has_gate(const RadarSlamOptions& options);

}  // namespace wayfare::examples
