#pragma once

#include <algorithm>
#include <cstddef>
#include <tuple>
#include <utility>

#include <gtest/gtest.h>

#include <wayfare/core/jacobian.hpp>
#include <wayfare/core/random.hpp>

namespace wayfare::testing {

/// A value at a random step of this size from the origin.
template <class X>
[[nodiscard]] X random_value(Rng& rng, double scale) {
  TangentOf<X> step;
  for (Eigen::Index k = 0; k < step.size(); ++k) step[k] = scale * rng.normal();
  return ManifoldTraits<X>::plus(manifold_origin<X>(), step);
}

/// Fails the current test unless f(x...) is finite and equals `value`, and its Jacobians `by` are
/// finite and equal differences to `tolerance` of an element, relative to the largest, from 1 up.
template <class Y, class F, class... V>
void expect_derivatives(const F& f, const Y& value, const JacobianBlocks<Y, V...>& by,
                        double tolerance, const V&... x) {
  JacobianBlocks<Y, V...> differences;
  const Y plain = differentiate<NumericJacobians, Y>(f, differences, x...);
  const auto apart = ManifoldTraits<Y>::minus(value, plain);
  ASSERT_TRUE(apart.allFinite());
  const double size = ManifoldTraits<Y>::minus(plain, manifold_origin<Y>()).cwiseAbs().maxCoeff();
  EXPECT_LE(apart.cwiseAbs().maxCoeff(), 1e-12 * (1.0 + size)) << "the value with the Jacobians";
  const auto same = [&](std::size_t i, const auto& j, const auto& by_difference) {
    ASSERT_TRUE(j.allFinite()) << "by argument " << i;
    EXPECT_LE((j - by_difference).cwiseAbs().maxCoeff(),
              tolerance * std::max(1.0, by_difference.cwiseAbs().maxCoeff()))
        << "by argument " << i << ":\n"
        << j << "\nand by differences\n"
        << by_difference;
  };
  [&]<std::size_t... I>(std::index_sequence<I...>) {
    (same(I, std::get<I>(by), std::get<I>(differences)), ...);
  }
  (std::index_sequence_for<V...>{});
}

}  // namespace wayfare::testing
