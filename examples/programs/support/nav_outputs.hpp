#pragma once

// Results and files of the navigation programs.

#include <string>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/eval/nav_error.hpp>
#include <wayfare/io/report.hpp>
#include <wayfare/nav/gnss_ins.hpp>

#include "nav_config.hpp"
#include "program_files.hpp"

namespace wayfare::examples {

/// A finished run. The references must outlive the calls.
struct NavOutputs {
  std::string title;
  const io::NavRecording& recording;
  const NavConfig& config;
  const GnssInsResult& run;
  std::vector<NavOutage> outages;
  double took_s = 0.0;
  double output_rate_hz = 0.0;  ///< of trajectory.txt; 0: that of the unit

  /// Since the unit's first sample.
  [[nodiscard]] double seconds(LogTime t) const {
    return to_seconds(t - recording.recording.imu.front().time);
  }
};

/// For the terminal and for the report.
struct NavFindings {
  eval::NavErrors errors;
  eval::PlainGnss plain;
  Facts facts;
  TitledTables tables;
  Doubt doubt;  ///< measurements refused
};
[[nodiscard]] NavFindings evaluate(const NavOutputs& run);

/// Facts and tables as text.
[[nodiscard]] std::string summary(const NavOutputs& run, const NavFindings& findings);
[[nodiscard]] io::Report report_of(const NavOutputs& run, const NavFindings& findings);

/// Positions of the unit with their deviations, at the rate of trajectory.txt.
[[nodiscard]] std::vector<GnssFix> track_of(const NavOutputs& run);

/// Writes trajectory.txt, trajectory.tum, states.txt and report.html.
[[nodiscard]] Result<void> write_nav_outputs(const OutputArguments& to, const NavOutputs& run,
                                             const NavFindings& findings);

}  // namespace wayfare::examples
