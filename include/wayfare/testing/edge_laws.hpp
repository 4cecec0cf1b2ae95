#pragma once

// The laws of the Edge concept, as checks on any type:
//
//   TEST(MyEdge, IsAnEdge) {
//     wayfare::testing::EdgeLaws<MyEdge>{{edge}}.check();      // at random values
//   }

#include <cstdint>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/graph/edge.hpp>
#include <wayfare/testing/detail/derivatives.hpp>

namespace wayfare::testing {

/// Fails the current test where an edge's Jacobians are not the derivatives of its error, or its
/// error is not finite at finite values.
template <Edge E>
struct EdgeLaws {
  std::vector<E> edges;     ///< checked one by one, at least one
  double scale = 1.0;       ///< size of the steps from the origin to the values tried
  int trials = 50;          ///< for each edge
  double tolerance = 1e-6;  ///< of a Jacobian's element, relative to the largest, from 1 up
  std::uint64_t seed = 1;   ///< of the values

  /// Every edge at random values of its variables.
  void check() const {
    ASSERT_FALSE(edges.empty()) << "no edges to check";
    Rng rng(seed);
    for (std::size_t i = 0; i < edges.size(); ++i)
      for (int trial = 0; trial < trials; ++trial) {
        SCOPED_TRACE("edge " + std::to_string(i) + ", trial " + std::to_string(trial));
        check_at(edges[i], rng, typename E::Variables{});
      }
  }

 private:
  template <class... V>
  void check_at(const E& edge, Rng& rng, EdgeVariables<V...>) const {
    const std::tuple<V...> x{random_value<V>(rng, scale)...};
    std::apply(
        [&](const V&... each) {
          JacobiansOf<E> jacobians;
          const EdgeError<E> from_jacobians = wayfare::linearise(edge, jacobians, each...);
          expect_derivatives<EdgeError<E>>([&](const auto&... v) { return edge.error(v...); },
                                           from_jacobians, jacobians.by, tolerance, each...);
        },
        x);
  }
};

}  // namespace wayfare::testing
