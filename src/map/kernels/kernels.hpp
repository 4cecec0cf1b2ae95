#pragma once

// The inner loops of maps, matching and localisation, each compiled for several instruction sets
// from one portable source. All variants give bit-identical results; best_kernels() is the fastest
// this CPU supports.

#include <cstddef>
#include <cstdint>

#include <wayfare/core/detail/isa.hpp>

namespace wayfare::kernels {

/// Rows and columns of candidate offsets in a block of scores.
inline constexpr int kBlock = 16;

/// Units of zeros before the grid in a bound table: a row of four groups may start 64 before it.
inline constexpr int kBoundMarginX = 68, kBoundMarginY = 20;

/// Rotation and translation of points to cells; du and dv are added to the rounded cells.
struct CellTransform {
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

/// Points in a part of the merged points; the last has fewer. Times a byte they fit 16 bits.
inline constexpr int kMergedPart = 256;

/// Points merged into entries, one for consecutive points in the same unit of a bound table.
struct Merged {
  const std::int32_t *x, *y;
  const std::uint16_t* weight;
  const std::int32_t* ends;  ///< number of entries up to each part's end
};

/// Units of 2^shift cells, counted from −(du, dv).
struct MergedUnit {
  int du, dv, shift;
};

/// More cells than the longest column has.
inline constexpr std::uint16_t kFarCells = 30000;
/// Its square: the value of a cell if the map has no obstacle.
inline constexpr std::int32_t kFarSquared = 900000000;
/// Cells of a row of distances processed at a time.
inline constexpr int kRowBlock = 32;
/// Rows with farther obstacles use the lower envelope, whose cost does not grow with the distance.
inline constexpr int kReach = 256;
/// Length of row_minimum's scratch row for n cells.
constexpr int scratch_length(int n) {
  return 2 * kReach + (n + kRowBlock - 1) / kRowBlock * kRowBlock;
}

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

/// A level of an NdtMap. Lengths in squares, from the corner of the square a distribution is in.
struct NdtTable {
  /// Of each tiling's squares, row-major with a border of one: a distribution, 0 for none.
  const std::int32_t* places[4];
  /// Eight values each: mean, upper triangle of the inverse covariance, 1 (0 for none), two unused.
  const float* distributions;
  int width, height;
};

/// Buckets of a SurfaceMap along a metre.
inline constexpr double kBucketsPerMetre = 4.0;

/// The points of a SurfaceMap, bucket by bucket; eight more may be read.
struct SurfaceTable {
  const float *x, *y;
  const std::uint32_t* first;       ///< point of each bucket, row-major, and the end
  int left, bottom, width, height;  ///< of the buckets
};

/// What is known of points' nearest neighbours, arrays of whole multiples of 16.
struct Neighbours {
  float *x, *y;                  ///< where they were searched
  std::int32_t* index;           ///< the nearest there, −1 for none
  float *nearest_x, *nearest_y;  ///< its place
  float* others;  ///< all others were at least so far; 0 for a point not searched yet
};

/// Points p of a scan and lines through q with normal n, arrays padded to 16 by zeros. q is
/// relative to any place of the map.
struct PointLines {
  const float *px, *py, *qx, *qy, *nx, *ny;
  int n;
};

/// Side of a tile of a grid, cells.
inline constexpr int kTileSide = 64;

/// How many beams pass the cells of a window of a tile: the sum of the differences along the row up
/// to a cell and of those along the column up to it. Columns are in parts of 16. Arrays start at
/// the window's first cell.
template <class Count>
struct TileDifferences {
  Count *along_rows, *along_columns;  ///< zero afterwards
  std::ptrdiff_t stride;              ///< between rows, a multiple of 64
  int rows, parts;                    ///< at most 64 and 4
  int first_part;                     ///< of the tile
  /// Sums left of the window and below it; afterwards with the window.
  Count *row_sums, *column_sums;
  /// Bits of cells of the tile's rows that count as not passed, stride / 64 words a row.
  const std::uint64_t* hits;
};

/// Bits of the window's rows and of the tile's columns in which something is.
struct TileExtent {
  std::uint64_t rows = 0, columns = 0;
};

/// How log-odds of cells change by passes. The limits by which they are clamped before the
/// addition, low and high − max_passes·step, must fit 16 bits.
struct PassUpdate {
  std::int16_t step, low, high;  ///< step ≠ 0 per pass, within [low, high], which contains 0
  std::int16_t unknown;          ///< value of a cell without an update, which starts from 0
  std::int16_t max_passes;
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
  /// Transforms n ≤ 256 points like `place`, adds du and dv, and adds the bounds of the group
  /// there: sums[k] += Σ, k < 16, column by column. Returns the largest sum. May read up to 15
  /// points past n.
  std::uint32_t (*point_bounds)(const float* x, const float* y, int n, const CellTransform& t,
                                const BoundTable& bounds, std::uint32_t* sums);
  /// Merges consecutive points in the same unit into one entry weighted by their number; entries do
  /// not span parts. x, y and weight have room for n entries and 15 more that are read; ends[p] is
  /// the number of entries up to the end of part p. Returns the number of entries.
  int (*merge)(const std::int32_t* u, const std::int32_t* v, int n, const MergedUnit& unit,
               std::int32_t* x, std::int32_t* y, std::uint16_t* weight, std::int32_t* ends);
  /// Adds the weighted bounds of one part of the entries, moved by (dx, dy) units
  /// (BoundTable::shift is not used): sums[16·g + k] += Σ for 1, 2 or 4 adjacent groups g along x.
  void (*merged_bounds)(const Merged& points, int part, const BoundTable& bounds, int dx, int dy,
                        int groups, std::uint32_t* sums);
  /// As `pair_scores`, weighted, of the entries of the first `parts`.
  void (*merged_pairs)(const Merged& points, int parts, const std::uint8_t* table, int stride,
                       const std::int32_t* index, std::uint32_t* sums);
  /// The same as `block_scores` of two rows.
  void (*merged_rows)(const Merged& points, int parts, const std::uint16_t* table, int stride,
                      const std::int32_t* index, std::uint32_t* sums);
  /// Transforms n points (arrays padded to 16) to (u, v), cell centres at integers, and sums f, g
  /// and the upper triangle of g gᵀ / (a + b·f), with (g₀, g₁) = (∂f/∂u, ∂f/∂v) rotated to the
  /// points' axes and g₂ = x·g₁ − y·g₀: sums[10] = {f, g₀, g₁, g₂, 00, 01, 02, 11, 12, 22}.
  void (*linearise)(const float* x, const float* y, int n, const CellTransform& t,
                    const Field& field, float a, float b, double* sums);
  /// The same with r = one − f, f bilinear or by Catmull-Rom cubics between 4×4 cells: sums[10] =
  /// {r², r g₀, r g₁, r g₂, g gᵀ as above}; outside the table f is the border's value.
  void (*bilinear_squares)(const float* x, const float* y, int n, const CellTransform& t,
                           const Field& field, float one, double* sums);
  void (*bicubic_squares)(const float* x, const float* y, int n, const CellTransform& t,
                          const Field& field, float one, double* sums);
  /// Sums e = exp(−½ dᵀΛd) of the points' offsets d from the distributions Λ of the four tilings,
  /// which are shifted by half a square along u, v and both, and with g = (−v, u) about the points'
  /// origin: sums[10] = {e, eΛd, e gᵀΛd, eΛ, eΛg, e gᵀΛg}, in squares and the tables' axes.
  void (*ndt_sums)(const float* x, const float* y, int n, const CellTransform& t,
                   const NdtTable& table, double* sums);
  /// index[i] = the nearest surface point within `radius` of each point, the first of equals, or
  /// −1, and its squared distance. Arrays of whole multiples of 16. Searches only where what is
  /// known does not suffice.
  void (*nearest)(const SurfaceTable& table, const float* x, const float* y, int n, float radius,
                  const Neighbours& known, std::int32_t* index, float* squares);
  /// With r = n·(R p + t − q), g = ∂r/∂(x, y, θ) in the points' axes and w = 1/(1 +
  /// r²·information): sums[10] = {ln(1 + r²·information), w r g, w g gᵀ as in linearise}. R, t = c,
  /// s, ox, oy.
  void (*line_squares)(const PointLines& lines, const CellTransform& t, float information,
                       double* sums);
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
  void (*field_sums)(const Field& field, const float* x, const float* y, int n,
                     const PoseBatch& poses, std::uint32_t* sums);
  /// passes[r·64 + c], 0 … 32767.
  TileExtent (*count_passes)(const TileDifferences<std::int16_t>& differences,
                             std::uint16_t* passes);
  /// cells[i] = clamp(cells[i] + step) as often as passed, for 16·parts cells of each row of 64.
  /// Cells that were not passed are unchanged.
  void (*add_passes)(std::int16_t* cells, const std::uint16_t* passes, int rows, int parts,
                     const PassUpdate& update);
  /// The same for cells c of row r passed once if bit c of bits[r] is set, of `parts` of 16
  /// columns.
  void (*add_marks)(std::int16_t* cells, const std::uint64_t* bits, int rows, int first_part,
                    int parts, const PassUpdate& update);
};

[[nodiscard]] const Kernels& kernels_for(Isa isa);
[[nodiscard]] const Kernels& best_kernels();

}  // namespace wayfare::kernels
