#pragma once

// Options of programs in JSON files.

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/slam/submap_slam.hpp>

namespace wayfare::examples {

/// An option with its name in a JSON file. Values are positive numbers, angles in degrees.
struct OptionField {
  std::string name;
  std::function<void(double)> set;
  std::function<double()> get;
  bool whole = false;  ///< written without a fraction
};

[[nodiscard]] OptionField option_field(const char* name, double& value);
[[nodiscard]] OptionField option_field(const char* name, int& value);
[[nodiscard]] OptionField option_field(const char* name, std::size_t& value);
[[nodiscard]] OptionField option_field(const char* name, Angle& value);

/// Sets the options that the JSON object in the file names. Errors: not JSON, an unknown key, a
/// value out of range.
Result<void> read_option_fields(const std::string& path, const std::vector<OptionField>& known);

/// All of them with their values, in the same format.
[[nodiscard]] std::string option_fields_text(const std::vector<OptionField>& fields);

/// The options of a JSON file.
[[nodiscard]] std::vector<OptionField> submap_slam_fields(SubmapSlamOptions& options);

/// Conditions beyond the range of each field.
[[nodiscard]] Result<void> check_grid(const MultiResolutionOptions& grid);
[[nodiscard]] Result<void> check_submap_slam(const SubmapSlamOptions& options);

}  // namespace wayfare::examples
