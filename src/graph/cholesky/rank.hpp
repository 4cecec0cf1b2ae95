#pragma once

// When a pivot is only rounding: one rule for all factorisations.
//
// With H = L Lᵀ let v = l_jj L⁻ᵀ e_j: one at j, zero after it, and before it the response that
// costs least. The pivot is l_jj² = vᵀHv, the information left along v. D is the diagonal of H
// before elimination, within each block the largest among the numbers of one unit, so that it does
// not depend on how axes are turned. H holds rounding errors |E_ab| ≲ ε √(D_a D_b), so vᵀHv is
// known to a few ε vᵀDv only. The direction v is undetermined where
//
//   l_jj² ≤ kRounding vᵀDv,  which is  (L⁻¹ D L⁻ᵀ)_jj ≥ 1 / kRounding.
//
// Neither the scale of H nor the units matter: D follows both. Exact null vectors leave a pivot of
// less than ε vᵀDv whatever the order of elimination, however the lengths of v's parts differ.

#include <cstdint>
#include <limits>

namespace wayfare::cholesky {

inline constexpr double kRounding = 32.0 * std::numeric_limits<double>::epsilon();
/// What makes a matrix that is singular to rounding positive definite, relative to D.
inline constexpr double kLift = kRounding / 4.0;
/// Random vectors by which (L⁻¹ D L⁻ᵀ)_jj = E (L⁻¹ D^½ z)_j² is estimated for all j at once, and
/// how far below the truth an estimate may be.
inline constexpr int kProbes = 4;
inline constexpr double kSlack = 0.1;
/// If the first of them are below this fraction of the limit, H is determined. The pivot of an
/// exact null vector is above 32 times the limit; that two estimates both fall so far short has a
/// chance of one in a million.
inline constexpr int kFirstProbes = 2;
inline constexpr double kDoubt = 1e-4;

/// Number `i` of probe `k`: symmetric about zero, uniform in ±[½, 3⁄2), the same in every run.
inline double probe(std::uint64_t i, int k) {
  std::uint64_t x = (i * kProbes + static_cast<std::uint64_t>(k) + 1) * 0x9E3779B97F4A7C15U;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9U;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBU;
  x ^= x >> 31;
  const double size = 0.5 + static_cast<double>(x >> 12) * 0x1p-52;
  return (x & 1U) != 0 ? size : -size;
}

}  // namespace wayfare::cholesky
