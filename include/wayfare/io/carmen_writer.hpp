#pragma once

#include <string>

#include <wayfare/core/result.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/sensors/recording.hpp>

namespace wayfare::io {

/// `recording` as a CARMEN log, all its streams in order of time: ODOM, WHEELS, GYRO, TRUEPOS and
/// RADAR lines and the scans, these with the odometry interpolated to them. A scan that a FLASER
/// line describes in full (half a turn from -90 deg in steps of 1 or 0.5 deg, the laser straight
/// ahead on the robot) becomes one, others become ROBOTLASER1. Numbers are written so that reading
/// them gives the same bits, times as exact seconds with nine decimals.
[[nodiscard]] std::string format_carmen(const Recording& recording);

[[nodiscard]] Result<void> write_carmen(const std::string& path, const Recording& recording,
                                        const WriteOptions& options = {});

}  // namespace wayfare::io
