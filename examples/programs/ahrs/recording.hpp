#pragma once

// Options of the programs on nine-axis recordings.

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
  ros::TopicNames topics;  ///< other topics of a ROS recording

  void add_options(CommandLine& app);
  /// For a program that also reads a log, whose --stamps applies to both.
  void add_options_beside_log(CommandLine& app);
  /// The argument `name`: the path of a recording, or of several.
  template <class Path>
  static void add_path(CommandLine& app, const std::string& name, Path& path) {
    app.add_option(
           name, path,
           "columns of text, a binary table, a ROS recording (ROS 2's .mcap, ROS 1's .bag), "
           "or a logger's recording (.mcap)")
        .required()
        .existing_file();
  }
  /// Reports skipped lines on standard error. The unit's mounting, from transforms of a ROS
  /// recording, goes to `q_base_unit`.
  [[nodiscard]] Result<io::MargFile> read(const std::string& path,
                                          std::optional<SO3d>* q_base_unit = nullptr) const;
};

struct FilterOptions {
  bool enu = false;
  bool no_magnetometer = false;
  double declination_deg = 0.0;
  std::optional<double> delay_s;

  void add_options(CommandLine& app);
  [[nodiscard]] AhrsParameters parameters() const;
};

}  // namespace wayfare::examples
