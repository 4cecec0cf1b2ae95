#pragma once

// The dense kernels of a multifrontal factorisation, compiled for several instruction sets from one
// portable source. All matrices are column-major. For a front with p pivots and m rows below them,
// L₁₁ is p×p (its diagonal stored as reciprocals) and L₂₁ m×p; leading dimensions of L₂₁ and of
// updates are multiples of kPad, rows past m are undefined.

#include <wayfare/core/detail/isa.hpp>

namespace wayfare::cholesky {

inline constexpr int kPad = 8;
constexpr int padded(int n) { return (n + kPad - 1) / kPad * kPad; }

/// Block `block` of H is added to a front: at block (row, column) of L₁₁ or L₂₁.
struct Placement {
  int block;
  int row, column;
  bool transposed, below;
};

/// Block rows [from, from + length) of a front's update are added to [to, to + length) of its
/// parent: of L₁₁ in a pivot run, else of L₂₁ and of the parent's update.
struct Run {
  int from, to, length;
};

struct Panel {
  double *l11, *l21;
  int pivots, rows;  // scalars
  int ld11, ld21;
};

/// A front's update and its rows in the parent.
struct Update {
  const double* values;
  int ld;
  const Run* runs;
  int pivot_runs, all_runs;
};

struct FrontKernels {
  void (*scatter)(const Placement* placements, int count, const double* h, const Panel& front);
  /// Adds the columns of pivot runs, or the others (the lower triangle only).
  void (*add_to_panel)(const Update& child, const Panel& front);
  void (*add_to_update)(const Update& child, double* update, int ld);
  /// Returns the pivot at which L₁₁ is not positive definite or not finite, or −1.
  int (*factorise)(const Panel& front);
  /// update = −L₂₁ L₂₁ᵀ, lower triangle.
  void (*update)(const Panel& front, double* update, int ld);
  /// to_i := from_index(i), blocks.
  void (*gather)(const int* index, int count, const double* from, double* to);
  /// One right-hand side y; the front's pivots begin at block `first`, `rows` are the blocks below:
  /// y₁ := L₁₁⁻¹ y₁, y₂ −= L₂₁ y₁. `scratch` has size ld11 + ld21.
  void (*forward)(const Panel& front, int first, const int* rows, double* y, double* scratch);
  /// y₁ := L₁₁⁻ᵀ (y₁ − L₂₁ᵀ y₂).
  void (*backward)(const Panel& front, int first, const int* rows, double* y, double* scratch);
  /// With Z = H⁻¹: Z₁₁ and Z₂₁ (in z's l11, full, and l21) from L and Z₂₂ (m×m, full, ld21). The
  /// scratch has size padded(p) · (2p + m).
  void (*invert)(const Panel& front, const Panel& z, const double* z22, double* scratch);
  /// A child's Z₂₂ from its parent's Z; the values of `child` are not used.
  void (*gather_inverse)(const Update& child, const Panel& z, const double* z22, double* child_z22);
};

/// `block` is 2, 3 or 6.
[[nodiscard]] const FrontKernels& kernels_for(Isa isa, int block);
[[nodiscard]] const FrontKernels& best_kernels(int block);

}  // namespace wayfare::cholesky
