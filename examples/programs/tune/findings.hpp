#pragma once

// What tuning brought: tables and curves.

#include <string>
#include <utility>
#include <vector>

#include <wayfare/eval/table.hpp>
#include <wayfare/io/report.hpp>

#include "drives.hpp"
#include "search.hpp"

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
  std::vector<std::pair<std::string, std::string>> facts;
};

using TitledTables = std::vector<std::pair<std::string, eval::Table>>;

/// Errors nominal beside tuned (Zhang 2020, tables 4 and 6), outages before and after (figure 3.9),
/// the parameters.
[[nodiscard]] TitledTables tables_of(const TuneFindings& findings);
/// With the convergence of one run (figure 3.3) and of all (figure 3.6).
[[nodiscard]] io::Report report_of(const TuneFindings& findings, const std::string& title);

}  // namespace wayfare::examples
