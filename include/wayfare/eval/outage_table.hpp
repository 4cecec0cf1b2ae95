#pragma once

#include <string>
#include <utility>
#include <vector>

#include <wayfare/eval/table.hpp>
#include <wayfare/nav/outage_errors.hpp>

namespace wayfare::eval {

/// One row per duration, one column per number of satellites left; `figure` selects the value.
[[nodiscard]] inline Table outage_table(const OutageReport& report, double OutageError::*figure,
                                        int decimals = 2) {
  std::vector<Table::Column> columns = {{"outage", "s"}};
  std::vector<std::vector<std::string>> rows;
  for (const OutageCell& c : report.cells) {
    if (c.duration == report.cells.front().duration)
      columns.push_back({std::to_string(c.satellites_left) +
                             (c.satellites_left == 1 ? " satellite" : " satellites"),
                         "m"});
    const std::string name = fixed(to_seconds(c.duration), 0);
    if (rows.empty() || rows.back().front() != name) rows.push_back({name});
    rows.back().push_back(fixed(c.mean.*figure, decimals));
  }
  Table table(columns);
  for (auto& row : rows) table.add_row(std::move(row));
  return table;
}

}  // namespace wayfare::eval
