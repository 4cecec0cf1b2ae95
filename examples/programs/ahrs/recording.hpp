#pragma once

// How the programs on nine-axis recordings are told about them.

#include <optional>
#include <string>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/core/so3.hpp>
#include <wayfare/inertial/ahrs_parameters.hpp>
#include <wayfare/io/marg_text.hpp>
#include <wayfare/ros/recording.hpp>

#include "support/command_line.hpp"

namespace wayfare::examples {

struct RecordingOptions {
  std::vector<std::string> columns;
  double period_s = 0.0;
  std::string topic;       ///< of the unit
  ros::TopicNames topics;  ///< the rest, of a ROS recording

  void describe(CommandLine& app);
  /// Where the program reads a log as well, whose choice of stamps holds for both.
  void describe_beside_log(CommandLine& app);
  /// The argument `name`: the path of a recording, or of several.
  static void add_path(CommandLine& app, const std::string& name, std::string& path);
  static void add_path(CommandLine& app, const std::string& name, std::vector<std::string>& paths);
  /// Says on standard error what had to be skipped. Where transforms of a ROS recording say how the
  /// unit sits on the robot, they go to `q_base_unit`.
  [[nodiscard]] Result<io::MargFile> read(const std::string& path,
                                          std::optional<SO3d>* q_base_unit = nullptr) const;
};

struct FilterOptions {
  bool enu = false;
  bool no_magnetometer = false;
  double declination_deg = 0.0;
  std::optional<double> delay_s;

  void describe(CommandLine& app);
  [[nodiscard]] AhrsParameters parameters() const;
};

}  // namespace wayfare::examples
