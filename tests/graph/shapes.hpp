#pragma once

// Patterns of special cases of a factorisation: (row, column) of the off-diagonal blocks.

#include <string>
#include <utility>
#include <vector>

#include "patterns.hpp"

namespace wayfare::tests {

struct Shape {
  std::string name;
  int columns = 0;
  std::vector<std::pair<int, int>> pairs;
};

/// Columns a … b − 1, all coupled to each other.
inline void join_all(int a, int b, std::vector<std::pair<int, int>>& pairs) {
  for (int i = a; i < b; ++i)
    for (int j = i + 1; j < b; ++j) pairs.emplace_back(j, i);
}

inline Shape chain(int n) {
  Shape s{"chain", n, {}};
  for (int i = 1; i < n; ++i) s.pairs.emplace_back(i - 1, i);
  return s;
}

/// All coupled only to column `hub`.
inline Shape arrow(int n, int hub) {
  Shape s{"arrow", n, {}};
  for (int i = 0; i < n; ++i)
    if (i != hub) s.pairs.emplace_back(i, hub);
  return s;
}

inline Shape grid(int width, int height) {
  Shape s{"grid", width * height, {}};
  for (int i = 0; i < s.columns; ++i) {
    if (i % width > 0) s.pairs.emplace_back(i, i - 1);
    if (i >= width) s.pairs.emplace_back(i, i - width);
  }
  return s;
}

inline std::vector<Shape> all_shapes(Rng& rng) {
  std::vector<Shape> shapes = {
      {"one block", 1, {}}, {"diagonal", 7, {}}, chain(2),      chain(40),
      arrow(30, 0),         arrow(30, 29),       arrow(90, 40), grid(7, 6)};
  Shape dense{"dense", 23, {}};
  join_all(0, 23, dense.pairs);
  shapes.push_back(dense);
  Shape apart = grid(4, 4);  // with a clique and isolated columns
  apart.name = "disconnected";
  apart.columns = 30;
  join_all(20, 26, apart.pairs);
  shapes.push_back(apart);
  for (const auto& [n, couplings] : {std::pair{12, 14}, {30, 45}, {50, 200}, {40, 700}})
    shapes.push_back({"random", n, random_pairs(rng, n, couplings)});
  return shapes;
}

}  // namespace wayfare::tests
