#pragma once

#include <span>
#include <vector>

namespace wayfare::cholesky {

/// Nanoseconds a front of so many columns, and rows below them, takes, about: to set up, to write
/// its update and add it to the parent's, and to compute.
[[nodiscard]] double front_cost_ns(int columns, int rows, int block);

/// A forest of supernodes: columns eliminated together in one dense front.
struct Supernodes {
  std::vector<int> order;   ///< old column of each new one; a supernode's columns follow each other
  std::vector<int> first;   ///< new column each begins at, and the number of columns at the end
  std::vector<int> parent;  ///< of each supernode; children come before parents
};

/// Puts columns (numbered in postorder) together where their patterns in L agree, and where they
/// agree nearly enough that a larger front costs less than another one. `counts` as of
/// column_counts, `block` scalars on a side. Among siblings, those come first that need more memory
/// while they are at work than they leave behind (Liu 1986, "On the storage requirement in the
/// out-of-core multifrontal method").
[[nodiscard]] Supernodes find_supernodes(std::span<const int> parent, std::span<const int> counts,
                                         int block);

}  // namespace wayfare::cholesky
