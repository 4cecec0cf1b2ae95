#pragma once

// The plan of a multifrontal factorisation: which columns are eliminated together, what the dense
// front of each looks like, and what goes where. Made once for a pattern.

#include <cstddef>
#include <span>
#include <vector>

#include "graph/cholesky/kernels.hpp"
#include "graph/cholesky/minimum_degree.hpp"

namespace wayfare::cholesky {

/// Columns [first, first + columns) in the new numbering, eliminated together. All counts are of
/// blocks.
struct Front {
  int first = 0, columns = 0;
  int rows = 0;        ///< below the eliminated columns
  int rows_begin = 0;  ///< of them in FrontPlan::rows
  int parent = -1;
  int children_begin = 0, children_end = 0;      ///< in FrontPlan::children
  int placements_begin = 0, placements_end = 0;  ///< in FrontPlan::placements
  int runs_begin = 0, pivot_runs = 0, runs = 0;  ///< in FrontPlan::runs: where this goes in parent
};

struct FrontPlan {
  int block = 0;              ///< scalars on a side
  std::vector<int> number;    ///< new number of each original column
  std::vector<int> order;     ///< … and back
  std::vector<Front> fronts;  ///< children before parents
  std::vector<int> rows;      ///< of each front, ascending, in the new numbering
  std::vector<int> children;
  std::vector<Placement> placements;
  std::vector<Run> runs;

  [[nodiscard]] std::span<const int> rows_of(const Front& f) const {
    return std::span(rows).subspan(static_cast<std::size_t>(f.rows_begin),
                                   static_cast<std::size_t>(f.rows));
  }
};

[[nodiscard]] FrontPlan plan_fronts(const UpperPattern& pattern, int block);

}  // namespace wayfare::cholesky
