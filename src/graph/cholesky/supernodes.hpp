#pragma once

#include <span>
#include <vector>

namespace wayfare::cholesky {

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

}  // namespace wayfare::cholesky
