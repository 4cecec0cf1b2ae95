// Ordering and plan, compared with column-by-column elimination.

#include "graph/cholesky/symbolic.hpp"

#include <algorithm>
#include <set>

#include <gtest/gtest.h>

#include <wayfare/graph/linear_solver.hpp>

#include <wayfare/testing/detail/block_matrices.hpp>

namespace wayfare::cholesky {
namespace {

UpperPattern pattern_of(const BlockSparse<3>& h) { return {h.starts(), h.rows()}; }

/// The rows below the diagonal of each column of L, with H's columns renumbered.
std::vector<std::set<int>> eliminate(const BlockSparse<3>& h, const std::vector<int>& number) {
  std::vector<std::set<int>> below(number.size());
  for (int c = 0; c < h.columns(); ++c) {
    for (int k = h.starts()[static_cast<std::size_t>(c)]; k < h.diagonal_index(c); ++k) {
      const int a = number[static_cast<std::size_t>(h.rows()[static_cast<std::size_t>(k)])];
      const int b = number[static_cast<std::size_t>(c)];
      below[static_cast<std::size_t>(std::min(a, b))].insert(std::max(a, b));
    }
  }
  for (auto& column : below) {
    if (column.empty()) continue;
    auto& parent = below[static_cast<std::size_t>(*column.begin())];
    parent.insert(std::next(column.begin()), column.end());
  }
  return below;
}

std::size_t fill_of(const BlockSparse<3>& h, const std::vector<int>& number) {
  std::size_t blocks = 0;
  for (const auto& column : eliminate(h, number)) blocks += column.size();
  return blocks;
}

TEST(MinimumDegree, OrdersEveryColumnOnceAndFillsLittle) {
  Rng rng(61);
  auto shapes = testing::all_shapes(rng);
  shapes.push_back(testing::arrow(900, 450));  // a dense hub, which is set aside
  shapes.push_back(testing::grid(30, 30));
  for (const auto& shape : shapes) {
    SCOPED_TRACE(shape.name + " of " + std::to_string(shape.columns));
    const BlockSparse<3> h(shape.columns, shape.pairs);
    const auto order = minimum_degree(pattern_of(h));
    auto sorted = order;
    std::sort(sorted.begin(), sorted.end());
    ASSERT_EQ(sorted.size(), static_cast<std::size_t>(shape.columns));
    for (int i = 0; i < shape.columns; ++i) EXPECT_EQ(sorted[static_cast<std::size_t>(i)], i);
    const std::size_t fill = fill_of(h, inverse_order(order));
    if (shape.name == "chain" || shape.name == "arrow") {
      EXPECT_EQ(fill, shape.pairs.size());  // no fill-in
    }
    // Little more than another implementation of the method with different tie-breaking.
    EXPECT_LE(static_cast<double>(fill),
              1.1 * static_cast<double>(fill_of(h, minimum_degree_order(h))) + 10.0);
  }
}

TEST(ColumnCounts, EqualThoseOfTheElimination) {
  Rng rng(62);
  for (const auto& shape : testing::all_shapes(rng)) {
    SCOPED_TRACE(shape.name + " of " + std::to_string(shape.columns));
    const BlockSparse<3> h(shape.columns, shape.pairs);
    auto order = minimum_degree(pattern_of(h));
    const auto first = elimination_tree(renumbered(pattern_of(h), inverse_order(order)));
    std::vector<int> both;
    for (const int i : postorder(first)) both.push_back(order[static_cast<std::size_t>(i)]);
    const ColumnLists above = renumbered(pattern_of(h), inverse_order(both));
    const auto parent = elimination_tree(above);
    const auto counts = column_counts(above, parent);
    const auto below = eliminate(h, inverse_order(both));
    for (std::size_t j = 0; j < below.size(); ++j) {
      EXPECT_EQ(parent[j], below[j].empty() ? -1 : *below[j].begin());
      EXPECT_EQ(counts[j], static_cast<int>(below[j].size()) + 1);
    }
  }
}

TEST(FrontPlan, ContainsTheFillInAndListsChildrenFirst) {
  Rng rng(63);
  for (const auto& shape : testing::all_shapes(rng)) {
    SCOPED_TRACE(shape.name + " of " + std::to_string(shape.columns));
    const BlockSparse<3> h(shape.columns, shape.pairs);
    const FrontPlan plan = plan_fronts(pattern_of(h), minimum_degree(pattern_of(h)), 3);
    const auto below = eliminate(h, plan.number);
    EXPECT_EQ(plan.placements.size(), static_cast<std::size_t>(h.blocks()));
    int next = 0;
    for (std::size_t s = 0; s < plan.fronts.size(); ++s) {
      const Front& f = plan.fronts[s];
      EXPECT_EQ(f.first, next);
      next += f.columns;
      const auto rows = plan.rows_of(f);
      EXPECT_TRUE(std::is_sorted(rows.begin(), rows.end()));
      for (int c = f.first; c < next; ++c)
        for (const int r : below[static_cast<std::size_t>(c)])
          EXPECT_TRUE(r < next || std::binary_search(rows.begin(), rows.end(), r));
      for (const int child : plan.children[s]) {
        EXPECT_LT(child, static_cast<int>(s));
        EXPECT_EQ(plan.fronts[static_cast<std::size_t>(child)].parent, static_cast<int>(s));
      }
    }
    EXPECT_EQ(next, shape.columns);
  }
}

}  // namespace
}  // namespace wayfare::cholesky
