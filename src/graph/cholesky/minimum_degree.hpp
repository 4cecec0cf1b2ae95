#pragma once

#include <span>
#include <vector>

namespace wayfare::cholesky {

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

}  // namespace wayfare::cholesky
