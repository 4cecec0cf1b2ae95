#pragma once

// Tables and report of outage_test.

#include <cstddef>
#include <string>
#include <vector>

#include <wayfare/eval/nav_error.hpp>
#include <wayfare/nav/outage.hpp>

#include "support/program_files.hpp"

namespace wayfare::examples {

/// Horizontal errors of filter and plain GNSS at range epochs outside of outages.
struct Outside {
  std::vector<double> filter, plain;
};

/// The outages with one set of options.
struct OutageVariant {
  std::string name;
  OutageReport report;
  Outside outside;
};

/// Means over the start times for each variant, and plain GNSS.
[[nodiscard]] TitledTables outage_tables(const std::vector<OutageVariant>& variants,
                                         std::size_t places);

/// The tables, and the drift in every outage.
[[nodiscard]] io::Report outage_report(const std::string& title, const std::string& description,
                                       const std::vector<OutageVariant>& variants,
                                       const TitledTables& tables);

}  // namespace wayfare::examples
