#pragma once

// Recordings of an inertial unit and a satellite receiver, from files of several kinds.

#include <functional>
#include <string>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/eval/nav_error.hpp>
#include <wayfare/io/nav_text.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/nav/gnss_ins.hpp>

namespace wayfare::io {

/// Of a text file of columns.
struct NavFileFormat {
  ColumnFormat format;
  /// Delay of the velocities' time stamps, s: those of many receivers are means over the interval
  /// that ends at the stamp.
  double velocity_late_s = 0.0;
};

struct NavFormats {
  std::vector<NavFileFormat> imu;  ///< one per file of the unit; empty: they name their columns
  NavFileFormat imu_clock, ranges, fixes, truth;
  /// Of raw observations.
  double elevation_mask_deg = 10.0;
  double min_cn0_dbhz = 0.0;
};

/// Paths; empty if there is none.
struct NavFiles {
  std::vector<std::string> imu;  ///< one, or gyro and accelerometer
  std::string imu_tags;          ///< RTKLIB's time tags of the (first) file of the unit
  std::string imu_clock;         ///< pairs of the unit's times and GPS times
  std::string observations;
  std::vector<std::string> navigation;
  std::string ranges;
  std::string fixes;
  std::string truth;
};

struct NavRecording {
  GnssInsRecording recording;
  eval::NavReference truth;
  /// What was skipped, sorted or left out.
  std::vector<std::string> remarks;
};

/// Readers of other file formats, and what is reported meanwhile.
struct NavReading {
  std::function<void(double)> progress = {};           ///< fraction of the raw observations
  std::function<void(const Problems&)> problems = {};  ///< of each file
  std::function<Result<ImuFile>(const std::string&, const ColumnFormat&)> imu = read_imu;
  std::function<Result<FixFile>(const std::string&, const ColumnFormat&)> fixes = read_fixes;
};

/// Reads all files and sorts each stream by time. Errors: those of the readers; no inertial samples
/// or no satellite measurements; streams that do not overlap in time, with the gap between them; a
/// delay of velocities that is not finite.
[[nodiscard]] Result<NavRecording> read_nav_recording(const NavFiles& files,
                                                      const NavFormats& formats = {},
                                                      const NavReading& reading = {});

}  // namespace wayfare::io
