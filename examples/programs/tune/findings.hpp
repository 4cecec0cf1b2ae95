#pragma once

// Results of tuning: tables and curves.

#include <string>
#include <vector>

#include "drives.hpp"
#include "search.hpp"
#include "support/program_files.hpp"

namespace wayfare::examples {

struct DriveFinding {
  std::string name;
  bool training = false;
  SystemErrors nominal, tuned;
  std::optional<OutageReport> nominal_outages, tuned_outages;
};

struct TuneFindings {
  std::vector<DriveFinding> drives;
  GnssInsOptions nominal, tuned;
  SearchResult search;
  double nominal_score = 0.0;
  Facts facts;
};

/// Errors nominal and tuned (Zhang 2020, tables 4 and 6), outages nominal and tuned (figure 3.9),
/// parameters.
[[nodiscard]] TitledTables tables_of(const TuneFindings& findings);
/// With the convergence of one run (figure 3.3) and of all (figure 3.6).
[[nodiscard]] io::Report report_of(const TuneFindings& findings, const std::string& title);

}  // namespace wayfare::examples
