#pragma once

#include <string>

#include <wayfare/core/result.hpp>
#include <wayfare/inertial/magnetometer_calibration.hpp>
#include <wayfare/io/text_file.hpp>

namespace wayfare::examples {

/// The calibration of a magnetometer as JSON (docs/reference/formats.md).
[[nodiscard]] Result<MagnetometerCalibration> read_calibration(const std::string& path);
[[nodiscard]] Result<void> write_calibration(const std::string& path,
                                             const MagnetometerCalibration& calibration,
                                             const io::WriteOptions& options);

}  // namespace wayfare::examples
