// Compiled once for each instruction set, with WAYFARE_ISA naming its namespace.

#include <cstddef>
#include <utility>

#include "map/kernels/kernels.hpp"

// Wide vectors are passed only between functions of this file, so the ABI does not matter.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace wayfare::kernels::WAYFARE_ISA {
namespace {

using std::int16_t;
using std::int32_t;
using std::uint16_t;
using std::uint32_t;
using std::uint64_t;
using std::uint8_t;

#include "map/kernels/wide.inl"

inline float saturated(float t, float limit) {
  const float low = t > -limit ? t : -limit;  // NaN becomes −limit
  return low < limit ? low : limit;
}
inline int32_t floored(float t) {
  const int32_t i = static_cast<int32_t>(t);
  return i - (t < static_cast<float>(i) ? 1 : 0);
}
inline int32_t clamped(int32_t v, int32_t low, int32_t high) {
  const int32_t a = v > low ? v : low;
  return a < high ? a : high;
}

void place(const float* __restrict x, const float* __restrict y, int n, float c, float s, float ox,
           float oy, float limit, int32_t* __restrict u, int32_t* __restrict v) {
  for (int i = 0; i < n; ++i) {
    u[i] = floored(saturated(c * x[i] - s * y[i] + ox, limit));
    v[i] = floored(saturated(s * x[i] + c * y[i] + oy, limit));
  }
}

void index(const int32_t* __restrict u, const int32_t* __restrict v, int n, int du, int dv,
           int width, int height, int stride, int32_t* __restrict out) {
  for (int i = 0; i < n; ++i) {
    out[i] = clamped(v[i] + dv, -kBlock, height) * stride + clamped(u[i] + du, -kBlock, width);
  }
}

// The sum of sixteen values of at most 4080 fits 16 bits; then it is widened.
template <int kRows>
void block_rows(const uint16_t* __restrict table, int stride, const int32_t* __restrict at, int n,
                uint32_t* __restrict sums) {
  for (int i = 0; i < kRows * kBlock; ++i) sums[i] = 0;
  for (int begin = 0; begin < n; begin += 16) {
    const int end = begin + 16 < n ? begin + 16 : n;
    Shorts acc[kRows];
    for (int i = begin; i < end; ++i) {
      const uint16_t* p = table + at[i];
      for (int r = 0; r < kRows; ++r) acc[r] += Shorts::loaded(p + static_cast<long>(r) * stride);
    }
    for (int r = 0; r < kRows; ++r) add_to(sums + r * kBlock, acc[r]);
  }
}

void block_scores(const uint16_t* table, int stride, const int32_t* at, int n, int rows,
                  uint32_t* sums) {
  // Eight rows of accumulators fit the registers of every instruction set.
  constexpr decltype(&block_rows<1>) kRows[] = {block_rows<1>, block_rows<2>, block_rows<3>,
                                                block_rows<4>, block_rows<5>, block_rows<6>,
                                                block_rows<7>, block_rows<8>};
  while (rows > 0) {
    const int now = rows < 8 ? rows : 8;
    kRows[now - 1](table, stride, at, n, sums);
    rows -= now;
    table += static_cast<long>(now) * stride;
    sums += now * kBlock;
  }
}

// Sums every second byte of a row, in 16-bit lanes that hold the sum of 256 bytes.
void pair_scores(const uint8_t* __restrict table, int stride, const int32_t* __restrict at, int n,
                 uint32_t* __restrict sums) {
  for (int k = 0; k < 16; ++k) sums[k] = 0;
  for (int begin = 0; begin < n; begin += 256) {
    const int end = begin + 256 < n ? begin + 256 : n;
    EightSums low = {}, high = {};
    for (int i = begin; i < end; ++i) {
      const uint8_t* p = table + at[i];
      low += even_bytes(p);
      high += even_bytes(p + 2L * stride);
    }
    for (int c = 0; c < 8; ++c) {
      sums[c] += low[c];
      sums[8 + c] += high[c];
    }
  }
}

// Indices in an interleaved bound table of the group whose corner is (u + du, v + dv).
void bound_index(const int32_t* __restrict u, const int32_t* __restrict v, int n, int du, int dv,
                 int shift, int width, int height, int columns, int32_t* __restrict out) {
  for (int i = 0; i < n; ++i) {
    const int32_t x = clamped((u[i] + du) >> shift, -kBoundMarginX, width) + kBoundMarginX;
    const int32_t y = clamped((v[i] + dv) >> shift, -kBoundMarginY, height) + kBoundMarginY;
    out[i] = (4 * y + (x & 3)) * columns + (x & ~3);
  }
}

inline uint32_t largest(const uint32_t* sums) {
  uint32_t top = 0;
  for (int k = 0; k < 16; ++k) top = top > sums[k] ? top : sums[k];
  return top;
}

// Blocks of 64 points stay in registers and the L1 cache; four sums hide the adder's latency.
uint32_t point_bounds(const float* __restrict x, const float* __restrict y, int n,
                      const CellTransform& t, const BoundTable& b, uint32_t* __restrict sums) {
  typedef uint8_t Bytes __attribute__((vector_size(16), aligned(1), may_alias));
  typedef uint16_t Lanes __attribute__((vector_size(32)));
  constexpr int kChunk = 64;
  int32_t u[kChunk], v[kChunk], at[kChunk];
  Lanes a[4] = {};
  for (int begin = 0; begin < n; begin += kChunk) {
    const int count = n - begin < kChunk ? n - begin : kChunk;
    const int whole = (count + 15) / 16 * 16;
    place(x + begin, y + begin, whole, t.c, t.s, t.ox, t.oy, t.limit, u, v);
    bound_index(u, v, whole, t.du, t.dv, b.shift, b.width, b.height, b.columns, at);
    int i = 0;
    for (; i + 3 < count; i += 4)
      for (int j = 0; j < 4; ++j)
        a[j] +=
            __builtin_convertvector(*reinterpret_cast<const Bytes*>(b.table + at[i + j]), Lanes);
    for (; i < count; ++i)
      a[0] += __builtin_convertvector(*reinterpret_cast<const Bytes*>(b.table + at[i]), Lanes);
  }
  const Lanes all = (a[0] + a[1]) + (a[2] + a[3]);  // the sum of 256 bytes fits 16 bits
  for (int k = 0; k < 16; ++k) sums[k] += all[k];
  return largest(sums);
}

#include "map/kernels/distances.inl"

#include "map/kernels/merged.inl"

#include "map/kernels/least_squares.inl"

#include "map/kernels/tables.inl"

#include "map/kernels/icp.inl"
#include "map/kernels/ndt.inl"
#include "map/kernels/raster.inl"

}  // namespace

extern const Kernels table;
const Kernels table = {
    place,         index,        block_scores, pair_scores, point_bounds,     merge,
    merged_bounds, merged_pairs, merged_rows,  linearise,   bilinear_squares, bicubic_squares,
    ndt_sums,      nearest,      line_squares, stamp,       interleave,       sixteenths,
    max_into,      min_max,      column_step,  column_back, row_minimum,      cast,
    field_sums,    count_passes, add_passes,   add_marks};

}  // namespace wayfare::kernels::WAYFARE_ISA
