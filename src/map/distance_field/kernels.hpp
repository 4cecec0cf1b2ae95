#pragma once

// The inner loops of distance fields and of localisation, each compiled for several instruction
// sets from one portable source. All variants give bit-identical results.

#include <cstdint>

#include <wayfare/core/detail/isa.hpp>

namespace wayfare::field_kernels {

/// More cells than the longest column has.
inline constexpr std::uint16_t kFarCells = 30000;
/// Its square: the value of a cell if the map has no obstacle.
inline constexpr std::int32_t kFarSquared = 900000000;
/// Cells of a row processed at a time.
inline constexpr int kBlock = 32;
/// Rows with farther obstacles use the lower envelope, whose cost does not grow with the distance.
inline constexpr int kReach = 256;
/// Length of the scratch row for n cells.
constexpr int scratch_length(int n) { return 2 * kReach + (n + kBlock - 1) / kBlock * kBlock; }

/// The map of a ray caster, with a border of −1: 0 where occupied, else the distance in cells
/// between the centres of a cell and of the nearest occupied one.
struct RayTable {
  const float* distance;  ///< of cell (−1, −1)
  int stride, width, height;
};

struct PoseBatch {
  const float *c, *s, *ox, *oy;  ///< u = c·x − s·y + ox, v = s·x + c·y + oy, in cells
  int n;
};

struct FieldTable {
  const std::uint16_t* table;  ///< of cell (0, 0); one cell around it may be read
  int stride, width, height;
};

struct Kernels {
  /// here[i] = occupied[i] ? 0 : min(before[i] + 1, kFarCells).
  void (*column_step)(const std::uint8_t* occupied, const std::uint16_t* before,
                      std::uint16_t* here, int n);
  /// here[i] = min(here[i], after[i] + 1).
  void (*column_back)(const std::uint16_t* after, std::uint16_t* here, int n);
  /// out[x] = min over x' of (x − x')² + column[x']², out padded to whole blocks. False if an
  /// obstacle may be farther than kReach: `out` is then incomplete.
  bool (*row_minimum)(const std::uint16_t* column, int n, std::int32_t* scratch, std::int32_t* out);
  /// Cells from (ix + fx, iy + fy) along (cos, sin) to the first occupied cell's border; `limit`
  /// where there is none within it. n a multiple of 16, limit at most 8000.
  void (*cast)(const RayTable& table, int ix, int iy, float fx, float fy, const float* cos,
               const float* sin, int n, float limit, float* cells);
  /// sums[p] = Σ table[cell of point i at pose p]; points outside count 0. n a multiple of 16.
  void (*field_sums)(const FieldTable& field, const float* x, const float* y, int n,
                     const PoseBatch& poses, std::uint32_t* sums);
};

[[nodiscard]] const Kernels& variant_for(Isa isa);
[[nodiscard]] const Kernels& best_variant();

}  // namespace wayfare::field_kernels
