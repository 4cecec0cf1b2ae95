#pragma once

// The symbolic plan of a multifrontal factorisation: the columns eliminated together, the layout of
// each dense front, and the assembly indices. Built once for a pattern.

#include <cstddef>
#include <span>
#include <vector>

#include "graph/cholesky/kernels.hpp"
#include "graph/cholesky/symbolic.hpp"

namespace wayfare::cholesky {

/// Columns [first, first + columns) in the new numbering, eliminated together. All counts are of
/// blocks.
struct Front {
  int first = 0, columns = 0;
  int rows = 0;        ///< below the eliminated columns
  int rows_begin = 0;  ///< in FrontPlan::rows
  int parent = -1;
  int placements_begin = 0, placements_end = 0;  ///< in FrontPlan::placements
  int runs_begin = 0, pivot_runs = 0, runs = 0;  ///< in FrontPlan::runs: its rows in the parent
};

struct FrontPlan {
  int block = 0;                ///< scalars per side
  std::vector<int> number;      ///< new number of each original column
  std::vector<int> order;       ///< the inverse
  std::vector<Front> fronts;    ///< children before parents
  std::vector<int> rows;        ///< of each front, ascending, in the new numbering
  detail::Lists<int> children;  ///< of each front, ascending
  std::vector<Placement> placements;
  std::vector<Run> runs;

  [[nodiscard]] std::span<const int> rows_of(const Front& f) const {
    return std::span(rows).subspan(static_cast<std::size_t>(f.rows_begin),
                                   static_cast<std::size_t>(f.rows));
  }
};

/// `order`: of elimination, as of minimum_degree; the plan's own differs without further fill-in.
[[nodiscard]] FrontPlan plan_fronts(const UpperPattern& pattern, std::vector<int> order, int block);

}  // namespace wayfare::cholesky
