#pragma once

// The laws of the concepts Manifold and LieGroup, as checks on any type:
//
//   TEST(MyState, IsAManifold) { wayfare::testing::ManifoldLaws<MyState>{}.check(); }
//   TEST(MyPose, IsALieGroup) { wayfare::testing::LieGroupLaws<MyPose>{}.check(); }
//
// Equation numbers: Solà et al., arXiv:1812.01537.

#include <cmath>
#include <cstddef>

#include <gtest/gtest.h>

#include <wayfare/testing/detail/law_inputs.hpp>

namespace wayfare::testing {

/// Fails the current test where ⊞ and ⊟ of a type break the laws of a manifold.
template <Manifold M>
struct ManifoldLaws {
  using Traits = ManifoldTraits<M>;        ///< the operations under test
  using Scalar = typename Traits::Scalar;  ///< of the tangent vectors
  using Tangent = TangentOf<M>;            ///< kDof × 1

  LawInputs<M> inputs{};  ///< points, tangent vectors and tolerance

  /// All laws of a manifold.
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

  /// Fails where ‖actual ⊟ expected‖ is above the tolerance.
  void expect_same(const M& actual, const M& expected, const char* law) const {
    expect_small(Traits::minus(actual, expected), law);
  }
  /// Fails where the norm is above the tolerance.
  void expect_small(const Tangent& difference, const char* law) const {
    EXPECT_LE(difference.norm(), inputs.tolerance) << law << ", off by " << difference.transpose();
  }
};

/// Fails the current test where a type breaks the laws of a manifold or of a Lie group.
template <LieGroup G>
struct LieGroupLaws : ManifoldLaws<G> {
  using Base = ManifoldLaws<G>;  ///< laws of the manifold
  using typename Base::Scalar;
  using typename Base::Tangent;
  using Jacobian = SquareOf<G>;  ///< kDof × kDof
  using Base::inputs;

  /// All laws of a manifold and of a group; action() where it acts on points.
  void check() const {
    Base::check();
    identity();
    inverse();
    associativity();
    exp_log_round_trip();
    powers();
    minus_ignores_a_common_left_factor();
    adjoint();
    right_jacobian();
    right_jacobian_inverse();
    left_and_right_jacobians();
    action();
  }

  /// e ∘ x = x ∘ e = x.
  void identity() const {
    for (const G& x : inputs.points) {
      this->expect_same(G::identity() * x, x, "e ∘ x = x");
      this->expect_same(x * G::identity(), x, "x ∘ e = x");
    }
  }

  /// x ∘ x⁻¹ = x⁻¹ ∘ x = e.
  void inverse() const {
    for (const G& x : inputs.points) {
      this->expect_same(x * x.inverse(), G::identity(), "x ∘ x⁻¹ = e");
      this->expect_same(x.inverse() * x, G::identity(), "x⁻¹ ∘ x = e");
    }
  }

  /// (x ∘ y) ∘ z = x ∘ (y ∘ z).
  void associativity() const {
    for (std::size_t i = 0; i < inputs.points.size(); ++i) {
      const G &x = inputs.points[i], &y = inputs.point(5 * i + 1), &z = inputs.point(11 * i + 4);
      this->expect_same((x * y) * z, x * (y * z), "(x ∘ y) ∘ z = x ∘ (y ∘ z)");
    }
  }

  /// log exp τ = τ inside the chart; exp log x = x everywhere.
  void exp_log_round_trip() const {
    for (const Tangent& tau : inputs.tangents) {
      this->expect_small(G::exp(tau).log() - tau, "log exp τ = τ");
      this->expect_same(G::exp(tau).inverse(), G::exp(-tau), "(exp τ)⁻¹ = exp(−τ)");
    }
    for (std::size_t i = 0; i < inputs.points.size(); ++i) {
      const G x = inputs.points[i] * inputs.point(3 * i + 5);
      this->expect_same(G::exp(x.log()), x, "exp log x = x");
    }
  }

  /// exp(τ/n)ⁿ = exp τ: a long product neither leaves the group nor drifts by more than one
  /// rounding error per factor.
  void powers() const {
    constexpr int kCount = 1000;
    for (const Tangent& tau : inputs.tangents) {
      const G factor = G::exp(tau / Scalar(kCount));
      G product = G::identity();
      for (int i = 0; i < kCount; ++i) product = product * factor;
      const Scalar allowed = Scalar(kCount) * Scalar(4) * LawInputs<G>::kEpsilon;
      EXPECT_LE(product.minus(G::exp(tau)).norm(), allowed) << "powers of exp " << tau.transpose();
    }
  }

  /// (z ∘ y) ⊟ (z ∘ x) = y ⊟ x: errors are in the body frame, independent of the world's origin.
  void minus_ignores_a_common_left_factor() const {
    for (std::size_t i = 0; i < inputs.tangents.size(); ++i) {
      const G &x = inputs.point(i), &z = inputs.point(7 * i + 2);
      const G y = x.plus(inputs.tangents[i]);
      this->expect_small((z * y).minus(z * x) - y.minus(x), "(z ∘ y) ⊟ (z ∘ x) = y ⊟ x");
    }
  }

  /// x ∘ exp τ ∘ x⁻¹ = exp(Ad x τ), Ad(x ∘ y) = Ad x Ad y (30)-(35).
  void adjoint() const {
    for (std::size_t i = 0; i < inputs.points.size(); ++i) {
      const G &x = inputs.points[i], &y = inputs.point(5 * i + 1);
      const Tangent tau = inputs.tangents[(3 * i + 2) % inputs.tangents.size()];
      this->expect_same(x * G::exp(tau) * x.inverse(), G::exp(x.adjoint() * tau),
                        "x ∘ exp τ ∘ x⁻¹ = exp(Ad x τ)");
      expect_same_matrix((x * y).adjoint(), x.adjoint() * y.adjoint(), "Ad(x ∘ y) = Ad x Ad y");
      expect_same_matrix(x.inverse().adjoint() * x.adjoint(), Jacobian::Identity(),
                         "Ad(x⁻¹) Ad x = I");
    }
  }

  /// exp(τ + δ) ≈ exp τ ∘ exp(Jr δ), against central differences (67).
  void right_jacobian() const {
    for (const Tangent& tau : inputs.tangents) {
      Jacobian numeric;
      for (int axis = 0; axis < G::kDof; ++axis) {
        const Tangent step = difference_step() * Tangent::Unit(axis);
        numeric.col(axis) = G::exp(tau + step).minus(G::exp(tau - step)) / (2 * difference_step());
      }
      expect_matrix_near(G::right_jacobian(tau), numeric, "Jr against differences",
                         difference_tolerance());
    }
  }

  /// Jr Jr⁻¹ = I.
  void right_jacobian_inverse() const {
    for (const Tangent& tau : inputs.tangents) {
      expect_same_matrix(G::right_jacobian(tau) * G::right_jacobian_inverse(tau),
                         Jacobian::Identity(), "Jr Jr⁻¹ = I");
    }
  }

  /// Ad(exp τ) Jr(τ) = Jl(τ) = Jr(−τ) (75), (76).
  void left_and_right_jacobians() const {
    for (const Tangent& tau : inputs.tangents) {
      expect_same_matrix(G::exp(tau).adjoint() * G::right_jacobian(tau),
                         G::right_jacobian(Tangent(-tau)), "Ad(exp τ) Jr(τ) = Jr(−τ)");
    }
  }

  /// For a group that acts on points: (x ∘ y) p = x (y p), e p = p.
  void action() const {
    if constexpr (requires(const G& x, typename G::Vector p) { p = x * p; }) {
      using Point = typename G::Vector;
      Point p = Point::LinSpaced(Scalar(-1), Scalar(2));
      for (std::size_t i = 0; i < inputs.points.size(); ++i) {
        const G &x = inputs.points[i], &y = inputs.point(5 * i + 1);
        EXPECT_LE(((x * y) * p - x * (y * p)).norm(), inputs.tolerance) << "(x ∘ y) p = x (y p)";
        EXPECT_LE((x.inverse() * (x * p) - p).norm(), inputs.tolerance) << "x⁻¹ (x p) = p";
      }
      EXPECT_EQ(G::identity() * p, p);
    }
  }

  /// Fails where ‖a − b‖ is above the tolerance of the inputs.
  void expect_same_matrix(const Jacobian& a, const Jacobian& b, const char* law) const {
    expect_matrix_near(a, b, law, inputs.tolerance);
  }
  /// Fails where ‖a − b‖ is above `tolerance`.
  static void expect_matrix_near(const Jacobian& a, const Jacobian& b, const char* law,
                                 Scalar tolerance) {
    EXPECT_LE((a - b).norm(), tolerance) << law << "\n" << a << "\nagainst\n" << b;
  }
  /// Balances the truncation error of central differences, h², with their rounding error, ε/h.
  static Scalar difference_step() { return std::cbrt(LawInputs<G>::kEpsilon); }
  /// Twenty times the truncation error of differences by that step.
  static Scalar difference_tolerance() { return 20 * difference_step() * difference_step(); }
};

}  // namespace wayfare::testing
