#pragma once

// The laws of a factor graph of one's own variables and edges that grows, as checks:
//
//   TEST(MyGraph, Grows) {
//     wayfare::testing::IncrementalLaws<MyGraph>{[](int step, MyGraph& graph) {
//       …  // adds what comes with this step, the first one with a fixed variable
//     }}.check();
//   }

#include <algorithm>
#include <cstddef>
#include <functional>
#include <limits>
#include <string>
#include <type_traits>

#include <gtest/gtest.h>

#include <wayfare/core/manifold.hpp>
#include <wayfare/graph/factor_graph.hpp>
#include <wayfare/graph/incremental.hpp>
#include <wayfare/graph/optimise.hpp>

namespace wayfare::testing {

/// Whether values, numbers of edges and fixed variables are the same, bit for bit.
template <class... V, class E>
[[nodiscard]] bool same(const FactorGraph<Variables<V...>, E>& a,
                        const FactorGraph<Variables<V...>, E>& b) {
  const auto equal = [&]<class X>(std::type_identity<X>) {
    const auto& of_a = a.template all<X>();
    const auto& of_b = b.template all<X>();
    bool same = of_a.size() == of_b.size();
    for (std::size_t i = 0; same && i < of_a.size(); ++i)
      same = ManifoldTraits<X>::minus(of_a[i], of_b[i]).isZero(0.0);
    return same;
  };
  return a.size() == b.size() && a.edge_count() == b.edge_count() && a.fixed() == b.fixed() &&
         (equal(std::type_identity<V>{}) && ...);
}

/// Fails the current test where the incremental optimiser differs from the batch optimiser on the
/// same graph, where what is refused or discarded leaves a trace, or where the number of threads
/// changes a result.
template <class Graph>
struct IncrementalLaws {
  /// Adds step 0, 1, … to a graph: variables at their initial values, edges, what is fixed.
  std::function<void(int step, Graph& graph)> grow;
  int steps = 20;           ///< number of steps
  double tolerance = 1e-6;  ///< of the cost, relative, from 1 up

  /// All laws.
  void check() const {
    equals_batch();
    refuses_without_a_trace();
    does_not_depend_on_threads();
  }

  /// With zero thresholds every step ends at the optimum that the batch optimiser finds from the
  /// same values, or both refuse it.
  void equals_batch() const {
    Graph whole;
    IncrementalGraphOptimiser<Graph> growing;
    int compared = 0;
    for (int step = 0; step < steps; ++step) {
      SCOPED_TRACE("step " + std::to_string(step));
      grow(step, whole);
      ASSERT_TRUE(growing.append(whole));
      Graph batch = growing.graph();
      const auto expected = optimise(batch, {.min_relative_gain = 1e-12, .min_absolute_gain = 0.0});
      const auto report =
          growing.update({.relinearise_step = 1e-9, .solve_change = 0.0, .max_rounds = 50});
      ASSERT_EQ(static_cast<bool>(report), static_cast<bool>(expected));
      if (!report) continue;
      ++compared;
      EXPECT_NEAR(report->cost, expected->final_cost,
                  tolerance * std::max(1.0, expected->final_cost));
    }
    EXPECT_GT(compared, 0) << "no step could be solved";
  }

  /// A graph that has lost variables is refused, and pending steps are discarded: neither changes
  /// what comes after.
  void refuses_without_a_trace() const {
    Graph whole;
    IncrementalGraphOptimiser<Graph> growing, disturbed;
    for (int step = 0; step < steps; ++step) {
      SCOPED_TRACE("step " + std::to_string(step));
      grow(step, whole);
      const Graph before = disturbed.graph();
      ASSERT_TRUE(disturbed.append(whole));
      EXPECT_FALSE(disturbed.append(Graph()));
      disturbed.discard_pending();
      EXPECT_TRUE(same(disturbed.graph(), before));
      ASSERT_TRUE(disturbed.append(whole));
      ASSERT_TRUE(growing.append(whole));
      ASSERT_EQ(static_cast<bool>(growing.update()), static_cast<bool>(disturbed.update()));
      EXPECT_TRUE(same(disturbed.graph(), growing.graph()));
    }
  }

  /// Full optimisations with 1, 2 and 5 threads end at the same values, bit for bit.
  void does_not_depend_on_threads() const {
    IncrementalGraphOptimiser<Graph> one;
    for (const int threads : {1, 2, 5}) {
      Graph whole;
      IncrementalGraphOptimiser<Graph> growing;
      for (int step = 0; step < steps; ++step) {
        grow(step, whole);
        ASSERT_TRUE(growing.append(whole));
        (void)growing.update();
        if (step % 7 == 6) (void)growing.optimise_fully({.threads = threads});
      }
      if (threads == 1) one = growing;
      EXPECT_TRUE(same(growing.graph(), one.graph())) << threads << " threads";
    }
  }
};

}  // namespace wayfare::testing
