#pragma once

// What outage_test finds, as tables and as a report.

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/eval/table.hpp>
#include <wayfare/io/report.hpp>
#include <wayfare/nav/outage.hpp>

namespace wayfare::examples {

/// The filter's and plain GNSS's horizontal errors at range epochs without an outage.
struct Outside {
  std::vector<double> filter, plain;
};

/// One column of the results: the same outages with one set of options.
struct OutageVariant {
  std::string name;
  OutageReport report;
  Outside outside;
  std::size_t epochs = 0;
};

using TitledTables = std::vector<std::pair<std::string, eval::Table>>;

/// Means over the places for each variant, and all beside plain GNSS.
[[nodiscard]] TitledTables outage_tables(const std::vector<OutageVariant>& variants,
                                         std::size_t places);

/// The tables, and the drift of every single outage.
[[nodiscard]] io::Report outage_report(const std::string& title, const std::string& how_made,
                                       const std::vector<OutageVariant>& variants,
                                       const TitledTables& tables);

}  // namespace wayfare::examples
