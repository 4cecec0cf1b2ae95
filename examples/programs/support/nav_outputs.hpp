#pragma once

// What the navigation programs measure and leave behind.

#include <string>
#include <utility>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/eval/table.hpp>
#include <wayfare/io/report.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/nav/gnss_ins.hpp>

#include "nav_config.hpp"
#include "nav_errors.hpp"
#include "nav_outages.hpp"
#include "nav_recording.hpp"

namespace wayfare::examples {

/// A finished run; everything referred to must outlive the call it is given to.
struct NavOutputs {
  std::string title;
  const NavRecording& recording;
  const NavConfig& config;
  const GnssInsResult& run;
  std::vector<NavOutage> outages;
  double took_s = 0.0;
  double output_rate_hz = 0.0;  ///< of trajectory.txt; 0: the unit's
};

/// What there is to say of a run: for the terminal and for the report.
struct NavFindings {
  NavErrors errors;
  PlainGnss plain;
  std::vector<std::pair<std::string, std::string>> facts;
  std::vector<std::pair<std::string, eval::Table>> tables;
};
[[nodiscard]] NavFindings find(const NavOutputs& run);

/// Facts and tables as text.
[[nodiscard]] std::string summary(const NavOutputs& run, const NavFindings& findings);
[[nodiscard]] io::Report report_of(const NavOutputs& run, const NavFindings& findings);

/// The files write_nav_outputs makes.
[[nodiscard]] std::vector<std::string> nav_output_names();

/// Gives the report's path.
[[nodiscard]] Result<std::string> write_nav_outputs(const std::string& folder,
                                                    const NavOutputs& run,
                                                    const NavFindings& findings,
                                                    const io::WriteOptions& options);

}  // namespace wayfare::examples
