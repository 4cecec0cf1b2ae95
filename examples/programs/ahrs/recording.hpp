#pragma once

// Options of the programs on nine-axis recordings, and of SLAM programs for an inertial unit beside
// the range finder; calibrations of magnetometers.

#include <optional>
#include <string>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/inertial/ahrs_parameters.hpp>
#include <wayfare/inertial/magnetometer_calibration.hpp>
#include <wayfare/io/nav_text.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/ros/recording.hpp>
#include <wayfare/sensors/recording.hpp>

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
    app.add_file(name, path,
                 "columns of text, a binary table, a ROS recording (ROS 2's .mcap, ROS 1's .bag), "
                 "or a logger's recording (.mcap)")
        .required();
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

struct UnitReadings {
  io::MargFile file;
  std::optional<SO3d> q_base_unit = {};  ///< from transforms of a ROS recording
};

struct UnitOptions {
  std::string path;  ///< empty: the unit in the log, if any
  bool none = false;
  std::string forward = "x";
  RecordingOptions recording;

  void add_options(CommandLine& app);
  /// The readings of --unit, else those of a unit in the log; with the stamps of the log. Nothing
  /// without a unit, or if `none` is set. A unit in the log that was not requested and cannot be
  /// used is reported on standard error.
  [[nodiscard]] Result<std::optional<UnitReadings>> read(const std::string& log,
                                                         const ros::TopicNames& topics) const;
  /// The unit's axis along which the laser's x points; z of both points up.
  [[nodiscard]] Eigen::Vector3d forward_axis() const;
  /// From the laser's axes to the unit's.
  [[nodiscard]] SO3d q_unit_laser() const;
  /// The same two by transforms of a ROS recording, else by --forward.
  [[nodiscard]] Eigen::Vector3d forward_axis(const UnitReadings& readings,
                                             const Recording& log) const;
  [[nodiscard]] SO3d q_unit_laser(const UnitReadings& readings, const Recording& log) const;
  /// From the unit's axes to the robot's, by transforms, else by --forward.
  [[nodiscard]] SO3d q_base_unit(const UnitReadings& readings, const Recording& log) const;
};

/// The calibration of a magnetometer as JSON (docs/reference/formats.md).
[[nodiscard]] Result<MagnetometerCalibration> read_calibration(const std::string& path);
[[nodiscard]] Result<void> write_calibration(const std::string& path,
                                             const MagnetometerCalibration& calibration,
                                             const io::WriteOptions& options);

}  // namespace wayfare::examples
