#pragma once

#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <vector>

#include <wayfare/core/manifold.hpp>
#include <wayfare/core/random.hpp>

namespace wayfare::testing {

/// Inputs of a law suite. The defaults suit every manifold whose chart extends to π; change the
/// members for a smaller chart, or to add the values of an application.
template <Manifold M>
struct LawInputs {
  using Scalar = typename ManifoldTraits<M>::Scalar;  ///< of the manifold
  using Tangent = TangentOf<M>;                       ///< kDof × 1

  /// Spacing of numbers at one.
  static constexpr Scalar kEpsilon = std::numeric_limits<Scalar>::epsilon();

  /// Tangent vectors within the chart, in which `minus` inverts `plus`.
  std::vector<Tangent> tangents = default_tangents();
  /// Points of the manifold.
  std::vector<M> points = points_from(tangents);
  /// Greatest rounding error, relative to numbers near one.
  Scalar tolerance = 100 * kEpsilon;

  /// Point i, again from the first after the last.
  [[nodiscard]] const M& point(std::size_t i) const { return points[i % points.size()]; }

  /// Both signs of every axis and a few random directions, at lengths from far below the square
  /// root of the rounding error, where a naive series loses precision, to just below π.
  [[nodiscard]] static std::vector<Tangent> default_tangents() {
    const double reach = std::numbers::pi - 4.0 * std::sqrt(static_cast<double>(kEpsilon));
    std::vector<Tangent> result{Tangent::Zero()};
    Rng rng(1);
    for (const double length :
         {1e-12, 1e-8, 1e-5, 1e-3, 0.03, 0.2, 0.4999, 0.5001, 1.0, 2.0, 3.0, reach}) {
      for (int axis = 0; axis < ManifoldTraits<M>::kDof; ++axis) {
        result.push_back(Scalar(length) * Tangent::Unit(axis));
        result.push_back(Scalar(-length) * Tangent::Unit(axis));
      }
      for (int k = 0; k < 3; ++k) {
        Tangent direction;
        for (auto& value : direction) value = Scalar(rng.normal());
        result.push_back(Scalar(length) * direction.normalized());
      }
    }
    return result;
  }

  /// The origin moved by each tangent vector.
  [[nodiscard]] static std::vector<M> points_from(const std::vector<Tangent>& tangents) {
    std::vector<M> result;
    for (const Tangent& tau : tangents) {
      result.push_back(ManifoldTraits<M>::plus(manifold_origin<M>(), tau));
    }
    return result;
  }
};

}  // namespace wayfare::testing
