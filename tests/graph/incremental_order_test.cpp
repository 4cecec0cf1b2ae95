#include <wayfare/graph/detail/incremental_order.hpp>

#include <algorithm>
#include <cstddef>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/graph/linear_solver.hpp>

#include <wayfare/testing/detail/block_matrices.hpp>

namespace wayfare {
namespace {

using Graph = std::vector<std::set<int>>;

/// Blocks of the factor below the diagonal, by eliminating node by node.
std::size_t fill_of(Graph graph, const std::vector<int>& order) {
  std::size_t fill = 0;
  for (const int pivot : order) {
    const std::set<int> joined = graph[static_cast<std::size_t>(pivot)];
    fill += joined.size();
    for (const int a : joined) {
      auto& others = graph[static_cast<std::size_t>(a)];
      others.insert(joined.begin(), joined.end());
      others.erase(a);
      others.erase(pivot);
    }
  }
  return fill;
}

Graph graph_of(const BlockSparse<3>& h) {
  Graph graph(static_cast<std::size_t>(h.columns()));
  for (int c = 0; c < h.columns(); ++c)
    for (int b = h.starts()[static_cast<std::size_t>(c)]; b < h.diagonal_index(c); ++b) {
      const int r = h.rows()[static_cast<std::size_t>(b)];
      graph[static_cast<std::size_t>(c)].insert(r);
      graph[static_cast<std::size_t>(r)].insert(c);
    }
  return graph;
}

void join_all_pairs(IncrementalOrder& order, const Graph& graph) {
  order.start(static_cast<int>(graph.size()));
  for (std::size_t a = 0; a < graph.size(); ++a)
    for (const int b : graph[a])
      if (static_cast<int>(a) < b) order.join(static_cast<int>(a), b);
}

bool is_permutation_of_all(std::vector<int> order, std::size_t nodes) {
  std::sort(order.begin(), order.end());
  for (std::size_t i = 0; i < order.size(); ++i)
    if (order[i] != static_cast<int>(i)) return false;
  return order.size() == nodes;
}

TEST(IncrementalOrder, FillsLittleMoreThanEigensMinimumDegree) {
  Rng rng(5);
  IncrementalOrder order;  // reused: nothing of the previous graph remains
  for (const auto& [columns, couplings] : {std::pair{60, 90}, {120, 150}, {40, 60}, {200, 420}}) {
    const BlockSparse<3> h(columns, testing::random_pairs(rng, columns, couplings));
    const Graph graph = graph_of(h);
    join_all_pairs(order, graph);
    const std::vector<int> ours = order.find();
    ASSERT_TRUE(is_permutation_of_all(ours, graph.size()));
    const std::vector<int> position = minimum_degree_order(h);
    std::vector<int> eigens(position.size());
    for (std::size_t i = 0; i < position.size(); ++i)
      eigens[static_cast<std::size_t>(position[i])] = static_cast<int>(i);
    EXPECT_LT(static_cast<double>(fill_of(graph, ours)),
              1.1 * static_cast<double>(fill_of(graph, eigens)));
  }
}

// A tree has an order without fill-in: children before parents.
TEST(IncrementalOrder, FillsNothingInATree) {
  Graph tree(50);
  for (int i = 1; i < 50; ++i) {
    tree[static_cast<std::size_t>(i)].insert((i - 1) / 3);
    tree[static_cast<std::size_t>((i - 1) / 3)].insert(i);
  }
  IncrementalOrder order;
  join_all_pairs(order, tree);
  EXPECT_EQ(fill_of(tree, order.find()), 49U);
}

TEST(IncrementalOrder, TreatsACliqueAsAllItsPairs) {
  Rng rng(8);
  for (int round = 0; round < 20; ++round) {
    const int nodes = 30;
    IncrementalOrder order;
    order.start(nodes);
    Graph graph(nodes);
    for (int c = 0; c < 9; ++c) {
      std::set<int> clique;
      while (clique.size() < 4) clique.insert(static_cast<int>(rng.below(nodes)));
      const std::vector<int> list(clique.begin(), clique.end());
      order.join_all(list);
      for (const int a : list)
        for (const int b : list)
          if (a != b) graph[static_cast<std::size_t>(a)].insert(b);
    }
    const std::vector<int> by_cliques = order.find();
    ASSERT_TRUE(is_permutation_of_all(by_cliques, nodes));
    IncrementalOrder pairs;
    join_all_pairs(pairs, graph);
    EXPECT_LE(static_cast<double>(fill_of(graph, by_cliques)),
              1.15 * static_cast<double>(fill_of(graph, pairs.find())));
  }
}

TEST(IncrementalOrder, OrdersTheGivenNodesLast) {
  Rng rng(2);
  const BlockSparse<3> h(40, testing::random_pairs(rng, 40, 70));
  IncrementalOrder order;
  join_all_pairs(order, graph_of(h));
  for (const int node : {31, 4, 17}) order.keep_last(node);
  const std::vector<int> found = order.find();
  ASSERT_TRUE(is_permutation_of_all(found, 40));
  EXPECT_EQ(std::vector<int>(found.end() - 3, found.end()), (std::vector<int>{4, 17, 31}));
}

}  // namespace
}  // namespace wayfare
