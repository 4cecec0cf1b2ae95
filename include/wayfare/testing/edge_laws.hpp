#pragma once

// The laws of the Edge concept, as checks on any type:
//
//   TEST(MyEdge, IsAnEdge) {
//     wayfare::testing::EdgeLaws<MyEdge>{{edge}}.check();      // at random values
//   }

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/graph/edge.hpp>

namespace wayfare::testing {

/// Fails the current test where an edge's Jacobians are not the derivatives of its error, or its
/// error is not finite at finite values.
template <Edge E>
struct EdgeLaws {
  std::vector<E> edges;
  double scale = 1.0;       ///< size of the steps from the origin to the values tried
  int trials = 50;          ///< for each edge
  double tolerance = 1e-6;  ///< of a Jacobian's element, relative to the largest, from 1 up
  std::uint64_t seed = 1;

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
  template <class X>
  X random_value(Rng& rng) const {
    TangentOf<X> step;
    for (Eigen::Index k = 0; k < step.size(); ++k) step[k] = scale * rng.normal();
    return ManifoldTraits<X>::plus(manifold_origin<X>(), step);
  }

  template <class... V>
  void check_at(const E& edge, Rng& rng, EdgeVariables<V...>) const {
    const std::tuple<V...> x{random_value<V>(rng)...};
    std::apply(
        [&](const V&... each) {
          JacobiansOf<E> jacobians, differences;
          const EdgeError<E> from_jacobians = wayfare::linearise(edge, jacobians, each...);
          const EdgeError<E> plain = edge.error(each...);
          ASSERT_TRUE(plain.allFinite());
          EXPECT_LE((from_jacobians - plain).cwiseAbs().maxCoeff(),
                    1e-12 * (1.0 + plain.cwiseAbs().maxCoeff()))
              << "the error of linearise";
          compare(edge, jacobians, differences, std::index_sequence_for<V...>{}, each...);
        },
        x);
  }

  template <std::size_t... I, class... V>
  void compare(const E& edge, const JacobiansOf<E>& given, JacobiansOf<E>& differences,
               std::index_sequence<I...>, const V&... x) const {
    (wayfare::detail::differentiate<I>(edge, differences, std::tuple<V...>(x...)), ...);
    const auto same = [&](std::size_t i, const auto& j, const auto& by_difference) {
      ASSERT_TRUE(j.allFinite()) << "by variable " << i;
      EXPECT_LE((j - by_difference).cwiseAbs().maxCoeff(),
                tolerance * std::max(1.0, by_difference.cwiseAbs().maxCoeff()))
          << "by variable " << i << ":\n"
          << j << "\nand by differences\n"
          << by_difference;
    };
    (same(I, std::get<I>(given.by), std::get<I>(differences.by)), ...);
  }
};

}  // namespace wayfare::testing
