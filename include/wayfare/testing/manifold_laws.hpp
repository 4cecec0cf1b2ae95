#pragma once

// The laws of the Manifold concept, as checks on any type:
//
//   TEST(MyState, IsAManifold) { wayfare::testing::ManifoldLaws<MyState>{}.check(); }

#include <cstddef>

#include <gtest/gtest.h>

#include <wayfare/testing/detail/law_inputs.hpp>

namespace wayfare::testing {

template <Manifold M>
struct ManifoldLaws {
  using Traits = ManifoldTraits<M>;
  using Scalar = typename Traits::Scalar;
  using Tangent = TangentOf<M>;

  LawInputs<M> inputs{};

  void check() const {
    zero_moves_nothing();
    plus_undoes_minus();
    minus_undoes_plus();
    difference_of_a_point_with_itself_is_zero();
    small_steps_add_up();
  }

  /// x ⊞ 0 = x.
  void zero_moves_nothing() const {
    for (const M& x : inputs.points) expect_same(Traits::plus(x, Tangent::Zero()), x, "x ⊞ 0 = x");
  }

  /// x ⊞ (y ⊟ x) = y, for every pair of points.
  void plus_undoes_minus() const {
    for (const M& x : inputs.points) {
      for (const M& y : inputs.points) {
        expect_same(Traits::plus(x, Traits::minus(y, x)), y, "x ⊞ (y ⊟ x) = y");
      }
    }
  }

  /// (x ⊞ τ) ⊟ x = τ, for every τ of the chart.
  void minus_undoes_plus() const {
    for (std::size_t i = 0; i < inputs.tangents.size(); ++i) {
      const Tangent& tau = inputs.tangents[i];
      const M& x = inputs.point(7 * i + 3);
      expect_small(Traits::minus(Traits::plus(x, tau), x) - tau, "(x ⊞ τ) ⊟ x = τ");
    }
  }

  /// x ⊟ x = 0.
  void difference_of_a_point_with_itself_is_zero() const {
    for (const M& x : inputs.points) expect_small(Traits::minus(x, x), "x ⊟ x = 0");
  }

  /// (x ⊞ δ₁) ⊞ δ₂ = x ⊞ (δ₁ + δ₂) up to the product of the two steps: the chart is smooth, with
  /// identity derivative at its origin.
  void small_steps_add_up() const {
    using std::sqrt;
    const Scalar step = sqrt(inputs.tolerance);
    for (std::size_t i = 0; i + 1 < inputs.tangents.size(); ++i) {
      const M& x = inputs.point(5 * i + 2);
      const Tangent a = step * inputs.tangents[i], b = step * inputs.tangents[i + 1];
      const Tangent error =
          Traits::minus(Traits::plus(Traits::plus(x, a), b), Traits::plus(x, Tangent(a + b)));
      EXPECT_LE(error.norm(), a.norm() * b.norm() + inputs.tolerance)
          << "straight plane, input " << i;
    }
  }

  void expect_same(const M& actual, const M& expected, const char* law) const {
    expect_small(Traits::minus(actual, expected), law);
  }
  void expect_small(const Tangent& difference, const char* law) const {
    EXPECT_LE(difference.norm(), inputs.tolerance) << law << ", off by " << difference.transpose();
  }
};

}  // namespace wayfare::testing
