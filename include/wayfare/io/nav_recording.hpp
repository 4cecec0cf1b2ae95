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
  ColumnFormat format;  ///< of its columns
  /// Delay of the velocities' time stamps, s: those of many receivers are means over the interval
  /// that ends at the stamp.
  double velocity_late_s = 0.0;
};

/// How the files of a recording are read.
struct NavFormats {
  std::vector<NavFileFormat> imu;  ///< one per file of the unit; empty: they name their columns
  NavFileFormat imu_clock,         ///< of the pairs of times
      ranges,                      ///< of corrected ranges
      fixes,                       ///< of fixes
      wheels,                      ///< of wheel speeds
      truth;                       ///< of the reference
  /// Of raw observations.
  double elevation_mask_deg = 10.0;
  double min_cn0_dbhz = 0.0;  ///< weaker signals are left out
};

/// Paths; empty if there is none.
struct NavFiles {
  std::vector<std::string> imu;  ///< one, or gyro and accelerometer
  std::string imu_tags;          ///< RTKLIB's time tags of the (first) file of the unit
  std::string imu_clock;         ///< pairs of the unit's times and GPS times
  std::string observations;      ///< RINEX or UBX, of the receiver
  /// RINEX, broadcast messages; not needed where UBX has those of GPS.
  std::vector<std::string> navigation;
  std::string ranges;  ///< corrected ranges as columns, instead of observations
  std::string fixes;   ///< of a receiver
  std::string truth;   ///< reference trajectory
  std::string wheels;  ///< speeds of wheels
};

/// What was read from all files.
struct NavRecording {
  GnssInsRecording recording;  ///< each stream in order of time
  eval::NavReference truth;    ///< empty without a file
  /// What was skipped, sorted or left out.
  std::vector<std::string> remarks;
};

/// Readers of other file formats, and what is reported meanwhile.
struct NavReading {
  std::function<void(double)> progress = {};           ///< fraction of the raw observations
  std::function<void(const Problems&)> problems = {};  ///< of each file
  /// Of the unit's files.
  std::function<Result<ImuFile>(const std::string&, const ColumnFormat&)> imu = read_imu;
  /// Of the file of fixes.
  std::function<Result<FixFile>(const std::string&, const ColumnFormat&)> fixes = read_fixes;
  bool apart = false;              ///< streams that do not overlap in time are no error
  double imu_time_offset_s = 0.0;  ///< of the unit's times, where the overlap is checked
};

/// Reads all files and sorts each stream by time. Errors: those of the readers; no inertial samples
/// or no satellite measurements; navigation messages of other days than the observations, with the
/// days; streams that do not overlap in time, with the gap between them; a delay of velocities that
/// is not finite.
[[nodiscard]] Result<NavRecording> read_nav_recording(const NavFiles& files,
                                                      const NavFormats& formats = {},
                                                      const NavReading& reading = {});

}  // namespace wayfare::io
