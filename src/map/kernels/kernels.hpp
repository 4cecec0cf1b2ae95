#pragma once

// The inner loops of map and match, each compiled for several instruction sets from one portable
// source. Every variant gives the same bits; kernels() is the best one this machine runs.

#include <cstdint>

#include <wayfare/core/detail/isa.hpp>

namespace wayfare::kernels {

/// Rows and columns of candidate offsets a block of scores covers.
inline constexpr int kBlock = 16;

/// Units of zeros before the grid in a bound table: a row of four groups may begin 64 before it.
inline constexpr int kBoundMarginX = 68, kBoundMarginY = 20;

/// A turn and shift in cells; the offsets are added to whole cells.
struct Turn {
  float c, s, ox, oy, limit;
  int du, dv;
};

/// Table values (0 … 4080) between cell centres; a border of at least 9 zeros is read.
struct Field {
  const std::uint16_t* table;
  int stride, width, height;
};

/// A level of a PrecomputationGrids, as bound_index reads it.
struct BoundTable {
  const std::uint8_t* table;
  int shift, width, height, columns;
};

/// The points of a part of merged ones; the last has fewer. Times a byte they fit 16 bits.
inline constexpr int kMergedPart = 256;

/// Entries of one or more points in the same unit of a bound table, in parts.
struct Merged {
  const std::int32_t *x, *y;
  const std::uint16_t* weight;
  const std::int32_t* ends;  ///< of the parts
};

/// Units of 2^shift cells, counted from −(du, dv).
struct MergedUnit {
  int du, dv, shift;
};

struct Kernels {
  /// u = floor(c·x − s·y + ox), v = floor(s·x + c·y + oy), saturated at ±limit; n a multiple of 16.
  void (*place)(const float* x, const float* y, int n, float c, float s, float ox, float oy,
                float limit, std::int32_t* u, std::int32_t* v);
  /// index = clamp(v + dv, −16, height)·stride + clamp(u + du, −16, width).
  void (*index)(const std::int32_t* u, const std::int32_t* v, int n, int du, int dv, int width,
                int height, int stride, std::int32_t* index);
  /// sums[r·16 + c] = Σ table[index + r·stride + c] for rows r < 16, values ≤ 4080.
  void (*block_scores)(const std::uint16_t* table, int stride, const std::int32_t* index, int n,
                       int rows, std::uint32_t* sums);
  /// Windows of two rows and columns: sums[r·8 + c] = Σ table[index + 2r·stride + 2c], r < 2, c
  /// < 8.
  void (*pair_scores)(const std::uint8_t* table, int stride, const std::int32_t* index, int n,
                      std::uint32_t* sums);
  /// Turns n ≤ 256 points like `place`, moves them by Turn::du and dv, and adds what the bound
  /// table holds for the group there: sums[k] += Σ, k < 16, column by column. The largest of the
  /// sums. May read up to 15 points past n.
  std::uint32_t (*turned_bounds)(const float* x, const float* y, int n, const Turn& turn,
                                 const BoundTable& bounds, std::uint32_t* sums);
  /// Points in the same unit, next to each other in the order, as one entry with their number;
  /// never of two parts. x, y and weight hold as many as the points, and 15 more that are read;
  /// ends[p] is how many there are up to part p. How many there are.
  int (*merge)(const std::int32_t* u, const std::int32_t* v, int n, const MergedUnit& unit,
               std::int32_t* x, std::int32_t* y, std::uint16_t* weight, std::int32_t* ends);
  /// Adds what the bound table holds for a part of the entries, (dx, dy) units on
  /// (BoundTable::shift is of no account), each as often as it weighs: sums[16·g + k] += Σ for 1, 2
  /// or 4 groups g beside each other along x.
  void (*merged_bounds)(const Merged& points, int part, const BoundTable& bounds, int dx, int dy,
                        int groups, std::uint32_t* sums);
  /// As `pair_scores`, of the entries of the first `parts`, each as often as it weighs.
  void (*merged_pairs)(const Merged& points, int parts, const std::uint8_t* table, int stride,
                       const std::int32_t* index, std::uint32_t* sums);
  /// Likewise as `block_scores` of two rows.
  void (*merged_rows)(const Merged& points, int parts, const std::uint16_t* table, int stride,
                      const std::int32_t* index, std::uint32_t* sums);
  /// Turns n points (arrays padded to 16) to (u, v), cell centres at whole numbers, and sums over
  /// them f, g and the upper triangle of g gᵀ / (a + b·f), g = (∂f/∂u, ∂f/∂v) turned back, and
  /// x·g₁ − y·g₀: sums[10] = {f, g₀, g₁, g₂, 00, 01, 02, 11, 12, 22}.
  void (*linearise)(const float* x, const float* y, int n, const Turn& turn, const Field& field,
                    float a, float b, double* sums);
  /// Likewise with r = one − f, f bilinear or by Catmull and Rom's cubics between 4×4 cells:
  /// sums[10] = {r², r g₀, r g₁, r g₂, g gᵀ as above}; f outside the table is what its border
  /// holds.
  void (*bilinear_squares)(const float* x, const float* y, int n, const Turn& turn,
                           const Field& field, float one, double* sums);
  void (*bicubic_squares)(const float* x, const float* y, int n, const Turn& turn,
                          const Field& field, float one, double* sums);
  /// Each target row r < rows: target[c] = max(target[c], kernel[r·width + c]); width % 16 = 0.
  void (*stamp)(std::uint16_t* target, int stride, const std::uint16_t* kernel, int width,
                int rows);
  /// out[p][4·e + j] = rows[j][4·e + p] for e < entries; p, j < 4.
  void (*interleave)(const std::uint8_t* const* rows, int entries, std::uint8_t* const* out);
  /// out[i] = ⌈values[i] / 16⌉.
  void (*sixteenths)(const std::uint16_t* values, int n, std::uint8_t* out);
  /// target[i] = max(target[i], other[i]); the two do not overlap.
  void (*max_into)(std::uint8_t* target, const std::uint8_t* other, int n);
  /// Smallest and largest value, n > 0.
  void (*min_max)(const std::int32_t* values, int n, std::int32_t* low, std::int32_t* high);
};

[[nodiscard]] const Kernels& kernels_for(Isa isa);
[[nodiscard]] const Kernels& best_kernels();

}  // namespace wayfare::kernels
