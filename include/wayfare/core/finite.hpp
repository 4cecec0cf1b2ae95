#pragma once

// Whether all numbers of a value are finite.

#include <wayfare/core/manifold.hpp>

namespace wayfare {

/// Whether every number of a value is finite.
template <Manifold M>
[[nodiscard]] bool has_finite_value(const M& x) {
  if constexpr (requires { x.translation().allFinite(), x.rotation(); }) {
    return x.translation().allFinite() && has_finite_value(x.rotation());
  } else if constexpr (requires { x.matrix().allFinite(); }) {
    return x.matrix().allFinite();
  } else {
    return ManifoldTraits<M>::minus(x, x).allFinite();  // ∞ − ∞ is not a number
  }
}

}  // namespace wayfare
