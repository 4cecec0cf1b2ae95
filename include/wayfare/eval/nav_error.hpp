#pragma once

// Error of a navigation solution.

#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <wayfare/eval/table.hpp>
#include <wayfare/nav/outage.hpp>
#include <wayfare/sensors/nav_state.hpp>

namespace wayfare::eval {

/// Truth minus estimate.
struct NavError {
  Eigen::Vector3d position_ned_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_ned_mps = Eigen::Vector3d::Zero();
  Eigen::Vector3d attitude_body_rad = Eigen::Vector3d::Zero();  ///< rotation vector
};

[[nodiscard]] inline NavError nav_error(const NavState& estimate, const NavState& truth) {
  return {ned_from_geodetic(truth.position, estimate.position),
          truth.velocity_ned_mps - estimate.velocity_ned_mps, truth.q_nb.minus(estimate.q_nb)};
}

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
