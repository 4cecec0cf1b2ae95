#pragma once

#include <span>
#include <vector>

#include "graph/cholesky/minimum_degree.hpp"

namespace wayfare::cholesky {

/// A pattern with renumbered columns: column c of the original is number[c]. Stores the rows above
/// the diagonal of each column, unordered.
class RenumberedPattern {
 public:
  RenumberedPattern(const UpperPattern& pattern, std::span<const int> number);

  [[nodiscard]] int columns() const { return static_cast<int>(starts_.size()) - 1; }
  [[nodiscard]] std::span<const int> above(int column) const;

 private:
  std::vector<int> starts_, rows_;
};

/// parent[j] = the row of the first block below the diagonal in column j of L, or −1 (Liu 1986, "A
/// compact row storage scheme for Cholesky factors using elimination trees").
[[nodiscard]] std::vector<int> elimination_tree(const RenumberedPattern& pattern);

/// Nodes of a forest, children before parents and each subtree contiguous.
[[nodiscard]] std::vector<int> postorder(std::span<const int> parent);

/// Blocks in each column of L, including the diagonal. Columns must be numbered in postorder
/// (Gilbert, Ng, Peyton 1994, "An efficient algorithm to compute row and column counts for sparse
/// Cholesky factorization").
[[nodiscard]] std::vector<int> column_counts(const RenumberedPattern& pattern,
                                             std::span<const int> parent);

/// inverse[order[k]] = k.
[[nodiscard]] std::vector<int> inverse_order(std::span<const int> order);

}  // namespace wayfare::cholesky
