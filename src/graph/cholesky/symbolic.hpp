#pragma once

// Symbolic analysis of a multifrontal Cholesky factorisation, once for a pattern: elimination
// order, elimination tree, the columns eliminated together, the layout of each dense front, and the
// assembly indices. All counts are of blocks.

#include <span>
#include <vector>

#include "graph/cholesky/kernels.hpp"
#include "graph/lists.hpp"

namespace wayfare::cholesky {

using detail::at;

/// A symmetric pattern: column c has rows r ≤ c, rows[starts[c]] … rows[starts[c + 1] − 1], the
/// diagonal last.
struct UpperPattern {
  std::span<const int> starts, rows;

  [[nodiscard]] int columns() const { return static_cast<int>(starts.size()) - 1; }
};

/// order[k] = the column eliminated k-th, for little fill-in: approximate minimum degree on the
/// quotient graph, with supervariables, mass elimination and aggressive absorption (Amestoy, Davis,
/// Duff 1996, "An approximate minimum degree ordering algorithm").
[[nodiscard]] std::vector<int> minimum_degree(const UpperPattern& pattern);

/// The rows above the diagonal of each column, unordered.
using ColumnLists = detail::Lists<int>;
/// With renumbered columns: column c of the original is number[c].
[[nodiscard]] ColumnLists renumbered(const UpperPattern& pattern, std::span<const int> number);

/// parent[j] = the row of the first block below the diagonal in column j of L, or −1 (Liu 1986, "A
/// compact row storage scheme for Cholesky factors using elimination trees").
[[nodiscard]] std::vector<int> elimination_tree(const ColumnLists& above);

/// Nodes of a forest, children before parents and each subtree contiguous.
[[nodiscard]] std::vector<int> postorder(std::span<const int> parent);

/// Blocks in each column of L, including the diagonal. Columns must be numbered in postorder
/// (Gilbert, Ng, Peyton 1994, "An efficient algorithm to compute row and column counts for sparse
/// Cholesky factorization").
[[nodiscard]] std::vector<int> column_counts(const ColumnLists& above, std::span<const int> parent);

/// inverse[order[k]] = k.
[[nodiscard]] std::vector<int> inverse_order(std::span<const int> order);

/// Approximate time of a front with this number of columns and rows below them, ns: setup, writing
/// and adding its update, and computation.
[[nodiscard]] double front_cost_ns(int columns, int rows, int block);

/// A forest of supernodes: columns eliminated together in one dense front.
struct Supernodes {
  std::vector<int> order;   ///< old column of each new one; a supernode's columns are contiguous
  std::vector<int> first;   ///< first new column of each, and the number of columns at the end
  std::vector<int> parent;  ///< of each supernode; children come before parents
};

/// Merges columns (numbered in postorder) whose patterns in L are equal, or so similar that a
/// larger front costs less than a further one. `counts`: see column_counts; `block`: scalars per
/// side. Siblings are ordered by the excess of their working memory over their update (Liu 1986,
/// "On the storage requirement in the out-of-core multifrontal method").
[[nodiscard]] Supernodes find_supernodes(std::span<const int> parent, std::span<const int> counts,
                                         int block);

/// Columns [first, first + columns) in the new numbering, eliminated together.
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
