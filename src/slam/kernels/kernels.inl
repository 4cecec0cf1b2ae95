// Included once for each instruction set with WAYFARE_ISA naming its namespace. Only raw pointers
// and built-in types: an inline function of the standard library compiled here could be the copy
// the linker keeps for everybody.

#include "kernels.hpp"

// Wide vectors are passed between functions of this file alone, which agree on how.
#pragma GCC diagnostic ignored "-Wpsabi"

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "narrow values are read in wider lanes");

namespace wayfare::kernels::WAYFARE_ISA {
namespace {

using std::int32_t;
using std::uint16_t;
using std::uint32_t;
using std::uint8_t;

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

// Sixteen values of at most 4080 fit 16 bits: sum that many in short lanes, then widen.
template <int kRows>
void block_rows(const uint16_t* __restrict table, int stride, const int32_t* __restrict at, int n,
                uint32_t* __restrict sums) {
  for (int i = 0; i < kRows * kBlock; ++i) sums[i] = 0;
  for (int begin = 0; begin < n; begin += 16) {
    const int end = begin + 16 < n ? begin + 16 : n;
    typedef uint16_t Lanes __attribute__((vector_size(2 * kBlock), aligned(2), may_alias));
    Lanes acc[kRows] = {};
    for (int i = begin; i < end; ++i) {
      const uint16_t* p = table + at[i];
      for (int r = 0; r < kRows; ++r)
        acc[r] += *reinterpret_cast<const Lanes*>(p + static_cast<long>(r) * stride);
    }
    for (int r = 0; r < kRows; ++r)
      for (int c = 0; c < kBlock; ++c) sums[r * kBlock + c] += acc[r][c];
  }
}

void block_scores(const uint16_t* table, int stride, const int32_t* at, int n, int rows,
                  uint32_t* sums) {
  // Eight rows of accumulators fit the registers of every instruction set.
  while (rows > 0) {
    const int now = rows < 8 ? rows : 8;
    switch (now) {
      case 1:
        block_rows<1>(table, stride, at, n, sums);
        break;
      case 2:
        block_rows<2>(table, stride, at, n, sums);
        break;
      case 3:
        block_rows<3>(table, stride, at, n, sums);
        break;
      case 4:
        block_rows<4>(table, stride, at, n, sums);
        break;
      case 5:
        block_rows<5>(table, stride, at, n, sums);
        break;
      case 6:
        block_rows<6>(table, stride, at, n, sums);
        break;
      case 7:
        block_rows<7>(table, stride, at, n, sums);
        break;
      default:
        block_rows<8>(table, stride, at, n, sums);
        break;
    }
    rows -= now;
    table += static_cast<long>(now) * stride;
    sums += now * kBlock;
  }
}

// Every second byte of a row is wanted: as the low bytes of 16-bit lanes, which 256 of them fit.
void pair_scores(const uint8_t* __restrict table, int stride, const int32_t* __restrict at, int n,
                 uint32_t* __restrict sums) {
  typedef uint16_t Lanes __attribute__((vector_size(16)));
  typedef Lanes Bytes __attribute__((aligned(1), may_alias));
  for (int k = 0; k < 16; ++k) sums[k] = 0;
  for (int begin = 0; begin < n; begin += 256) {
    const int end = begin + 256 < n ? begin + 256 : n;
    Lanes low = {}, high = {};
    for (int i = begin; i < end; ++i) {
      const uint8_t* p = table + at[i];
      low += *reinterpret_cast<const Bytes*>(p) & 0xff;
      high += *reinterpret_cast<const Bytes*>(p + 2L * stride) & 0xff;
    }
    for (int c = 0; c < 8; ++c) {
      sums[c] += low[c];
      sums[8 + c] += high[c];
    }
  }
}

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

// 256 bytes fit 16 bits.
uint32_t bound_scores(const uint8_t* __restrict table, const int32_t* __restrict at, int n,
                      uint32_t* __restrict sums) {
  typedef uint8_t Bytes __attribute__((vector_size(16), aligned(1), may_alias));
  typedef uint16_t Lanes __attribute__((vector_size(32)));
  for (int begin = 0; begin < n; begin += 256) {
    const int end = begin + 256 < n ? begin + 256 : n;
    Lanes even = {}, odd = {};
    int i = begin;
    for (; i + 1 < end; i += 2) {
      even += __builtin_convertvector(*reinterpret_cast<const Bytes*>(table + at[i]), Lanes);
      odd += __builtin_convertvector(*reinterpret_cast<const Bytes*>(table + at[i + 1]), Lanes);
    }
    if (i < end)
      even += __builtin_convertvector(*reinterpret_cast<const Bytes*>(table + at[i]), Lanes);
    for (int k = 0; k < 16; ++k)
      sums[k] += static_cast<uint32_t>(even[k]) + static_cast<uint32_t>(odd[k]);
  }
  return largest(sums);
}

// Pairs of bytes as 16-bit lanes: the high ones apart, and out of the sum of both at the end.
void row_bound_scores(const uint8_t* __restrict table, const int32_t* __restrict at, int n,
                      uint32_t* __restrict sums, uint32_t* __restrict top) {
  typedef uint16_t Lanes __attribute__((vector_size(64)));
  typedef Lanes Bytes __attribute__((aligned(1), may_alias));
  for (int begin = 0; begin < n; begin += 256) {
    const int end = begin + 256 < n ? begin + 256 : n;
    Lanes both = {}, high = {};
    for (int i = begin; i < end; ++i) {
      const Lanes pairs = *reinterpret_cast<const Bytes*>(table + at[i]);
      both += pairs;
      high += pairs >> 8;
    }
    both -= high << 8;
    for (int k = 0; k < 32; ++k) {
      sums[2 * k] += both[k];
      sums[2 * k + 1] += high[k];
    }
  }
  for (int g = 0; g < 4; ++g) top[g] = largest(sums + 16 * g);
}

// Blocks of 64 points stay in registers and the nearest cache; four sums hide the adder's latency.
uint32_t turned_bounds(const float* __restrict x, const float* __restrict y, int n,
                       const Turn& turn, const BoundTable& b, uint32_t* __restrict sums) {
  typedef uint8_t Bytes __attribute__((vector_size(16), aligned(1), may_alias));
  typedef uint16_t Lanes __attribute__((vector_size(32)));
  constexpr int kChunk = 64;
  int32_t u[kChunk], v[kChunk], at[kChunk];
  Lanes a[4] = {};
  for (int begin = 0; begin < n; begin += kChunk) {
    const int count = n - begin < kChunk ? n - begin : kChunk;
    const int whole = (count + 15) / 16 * 16;
    place(x + begin, y + begin, whole, turn.c, turn.s, turn.ox, turn.oy, turn.limit, u, v);
    bound_index(u, v, whole, turn.du, turn.dv, b.shift, b.width, b.height, b.columns, at);
    int i = 0;
    for (; i + 3 < count; i += 4)
      for (int j = 0; j < 4; ++j)
        a[j] +=
            __builtin_convertvector(*reinterpret_cast<const Bytes*>(b.table + at[i + j]), Lanes);
    for (; i < count; ++i)
      a[0] += __builtin_convertvector(*reinterpret_cast<const Bytes*>(b.table + at[i]), Lanes);
  }
  const Lanes all = (a[0] + a[1]) + (a[2] + a[3]);  // 256 bytes fit 16 bits
  for (int k = 0; k < 16; ++k) sums[k] += all[k];
  return largest(sums);
}

// Lanes of sixteen in every variant, so that the sums round alike; lanes past the end read zeros.
// The lanes' sums go to double precision every 512 points.
typedef float Reals __attribute__((vector_size(64), aligned(4), may_alias));
typedef int32_t Ints __attribute__((vector_size(64)));

/// Sixteen points of the field: the cell below and left of each, and how far beyond it they are.
struct Places {
  Reals x, y, fu, fv;
  Ints at;
};

inline Places placed(const float* x, const float* y, const Turn& turn, const Field& field) {
  Places p;
  p.x = *reinterpret_cast<const Reals*>(x);
  p.y = *reinterpret_cast<const Reals*>(y);
  Reals u = turn.c * p.x - turn.s * p.y + turn.ox, v = turn.s * p.x + turn.c * p.y + turn.oy;
  const Reals right = Reals{} + static_cast<float>(field.width + 4);
  const Reals top = Reals{} + static_cast<float>(field.height + 4), low = Reals{} - 4.0F;
  u = u > low ? u : low;
  u = u < right ? u : right;
  v = v > low ? v : low;
  v = v < top ? v : top;
  const Ints column = __builtin_convertvector(u + 8.0F, Ints) - 8;
  const Ints row = __builtin_convertvector(v + 8.0F, Ints) - 8;
  p.fu = u - __builtin_convertvector(column, Reals);
  p.fv = v - __builtin_convertvector(row, Reals);
  p.at = row * field.stride + column;
  return p;
}

/// f and its derivatives along the table's axes.
struct Samples {
  Reals f, gu, gv;
};

/// Two neighbouring cells, `offset` from where each point is.
inline Ints pairs(const uint16_t* table, const Ints& at, long offset, int lanes) {
  typedef int32_t Pair __attribute__((aligned(2), may_alias));
  Ints found = {};
  for (int j = 0; j < lanes; ++j) found[j] = *reinterpret_cast<const Pair*>(table + at[j] + offset);
  return found;
}
inline Reals first_of(const Ints& pair) { return __builtin_convertvector(pair & 0xffff, Reals); }
inline Reals second_of(const Ints& pair) { return __builtin_convertvector(pair >> 16, Reals); }

inline Samples bilinear(const Places& p, const Field& field, int lanes) {
  const Ints near = pairs(field.table, p.at, 0, lanes);
  const Ints far = pairs(field.table, p.at, field.stride, lanes);
  const Reals p00 = first_of(near), p10 = second_of(near);
  const Reals p01 = first_of(far), p11 = second_of(far);
  const Reals du0 = p10 - p00, du1 = p11 - p01;
  const Reals f0 = p00 + p.fu * du0, gv = p01 + p.fu * du1 - f0;
  return {f0 + p.fv * gv, du0 + p.fv * (du1 - du0), gv};
}

/// Catmull and Rom's weights of four neighbours a fraction t beyond the second, and their slopes.
struct CubicWeights {
  Reals w[4], slope[4];

  explicit CubicWeights(const Reals& t) {
    w[0] = 0.5F * t * ((2.0F - t) * t - 1.0F);
    w[1] = 0.5F * (t * t * (3.0F * t - 5.0F) + 2.0F);
    w[2] = 0.5F * t * ((4.0F - 3.0F * t) * t + 1.0F);
    w[3] = 0.5F * t * t * (t - 1.0F);
    slope[0] = 0.5F * ((4.0F - 3.0F * t) * t - 1.0F);
    slope[1] = 0.5F * t * (9.0F * t - 10.0F);
    slope[2] = 0.5F * ((8.0F - 9.0F * t) * t + 1.0F);
    slope[3] = 0.5F * t * (3.0F * t - 2.0F);
  }
};

inline Samples bicubic(const Places& p, const Field& field, int lanes) {
  const CubicWeights u(p.fu), v(p.fv);
  Samples s = {};
  for (int k = 0; k < 4; ++k) {
    const long row = static_cast<long>(k - 1) * field.stride;
    const Ints left = pairs(field.table, p.at, row - 1, lanes);
    const Ints right = pairs(field.table, p.at, row + 1, lanes);
    const Reals a = first_of(left), b = second_of(left), c = first_of(right), d = second_of(right);
    const Reals value = u.w[0] * a + u.w[1] * b + u.w[2] * c + u.w[3] * d;
    const Reals slope = u.slope[0] * a + u.slope[1] * b + u.slope[2] * c + u.slope[3] * d;
    s.f += v.w[k] * value;
    s.gu += v.w[k] * slope;
    s.gv += v.slope[k] * value;
  }
  return s;
}

/// Adds add(f, gradient in the points' axes and about their origin, acc) of sixteen points at a
/// time, in single precision by blocks.
template <class Sample, class Add>
inline void sum_over(const float* __restrict x, const float* __restrict y, int n, const Turn& turn,
                     const Field& field, double* __restrict sums, Sample sample, Add add) {
  const float cells = 1 / __builtin_sqrtf(turn.c * turn.c + turn.s * turn.s);
  const float c = turn.c * cells, s = turn.s * cells;
  for (int k = 0; k < 10; ++k) sums[k] = 0;
  for (int block = 0; block < n; block += 512) {
    const int end = n - block < 512 ? n : block + 512;
    Reals acc[10] = {};
    for (int i = block; i < end; i += 16) {
      const Places p = placed(x + i, y + i, turn, field);
      const int lanes = end - i < 16 ? end - i : 16;
      const Samples f = sample(p, field, lanes);
      const Reals g0 = c * f.gu + s * f.gv, g1 = c * f.gv - s * f.gu, g2 = p.x * g1 - p.y * g0;
      add(f.f, g0, g1, g2, lanes, acc);
    }
    for (int k = 0; k < 10; ++k)
      for (int j = 0; j < 16; ++j) sums[k] += static_cast<double>(acc[k][j]);
  }
}

inline void add_outer(const Reals& w, const Reals& g0, const Reals& g1, const Reals& g2,
                      Reals* acc) {
  const Reals w0 = w * g0, w1 = w * g1;
  acc[4] += w0 * g0;
  acc[5] += w0 * g1;
  acc[6] += w0 * g2;
  acc[7] += w1 * g1;
  acc[8] += w1 * g2;
  acc[9] += w * g2 * g2;
}

void linearise(const float* __restrict x, const float* __restrict y, int n, const Turn& turn,
               const Field& field, float a, float b, double* __restrict sums) {
  const auto add = [=](const Reals& f, const Reals& g0, const Reals& g1, const Reals& g2, int,
                       Reals* acc) {
    acc[0] += f;
    acc[1] += g0;
    acc[2] += g1;
    acc[3] += g2;
    add_outer(1.0F / (a + b * f), g0, g1, g2, acc);
  };
  sum_over(x, y, n, turn, field, sums, bilinear, add);
}

template <class Sample>
inline void squares(const float* __restrict x, const float* __restrict y, int n, const Turn& turn,
                    const Field& field, float one, double* __restrict sums, Sample sample) {
  const auto add = [=](const Reals& f, const Reals& g0, const Reals& g1, const Reals& g2, int lanes,
                       Reals* acc) {
    Reals r = one - f;
    for (int j = lanes; j < 16; ++j) r[j] = 0;
    acc[0] += r * r;
    acc[1] += r * g0;
    acc[2] += r * g1;
    acc[3] += r * g2;
    add_outer(Reals{} + 1.0F, g0, g1, g2, acc);
  };
  sum_over(x, y, n, turn, field, sums, sample, add);
}

void bilinear_squares(const float* x, const float* y, int n, const Turn& turn, const Field& field,
                      float one, double* sums) {
  squares(x, y, n, turn, field, one, sums, bilinear);
}
void bicubic_squares(const float* x, const float* y, int n, const Turn& turn, const Field& field,
                     float one, double* sums) {
  squares(x, y, n, turn, field, one, sums, bicubic);
}

void stamp(uint16_t* __restrict target, int stride, const uint16_t* __restrict kernel, int width,
           int rows) {
  for (int r = 0; r < rows; ++r) {
    for (int b = 0; b < width; b += 16) {
      for (int c = b; c < b + 16; ++c) target[c] = target[c] > kernel[c] ? target[c] : kernel[c];
    }
    target += stride;
    kernel += width;
  }
}

// A 4×4 transposition of bytes in every four 32-bit words, little end first.
void interleave(const uint8_t* const* rows, int entries, uint8_t* const* out) {
  typedef uint32_t Word __attribute__((aligned(1), may_alias));
  const Word* in[4];
  Word* to[4];
  for (int j = 0; j < 4; ++j) {
    in[j] = reinterpret_cast<const Word*>(rows[j]);
    to[j] = reinterpret_cast<Word*>(out[j]);
  }
  const Word* __restrict a = in[0], * __restrict b = in[1], * __restrict c = in[2], * __restrict d = in[3];
  Word* __restrict o = to[0], * __restrict p = to[1], * __restrict q = to[2], * __restrict r = to[3];
  for (int e = 0; e < entries; ++e) {
    const uint32_t ab = (a[e] & 0x00ff00ff) | ((b[e] & 0x00ff00ff) << 8);
    const uint32_t cd = (c[e] & 0x00ff00ff) | ((d[e] & 0x00ff00ff) << 8);
    const uint32_t ba = ((a[e] >> 8) & 0x00ff00ff) | (b[e] & 0xff00ff00);
    const uint32_t dc = ((c[e] >> 8) & 0x00ff00ff) | (d[e] & 0xff00ff00);
    o[e] = (ab & 0xffff) | (cd << 16);
    q[e] = (ab >> 16) | (cd & 0xffff0000);
    p[e] = (ba & 0xffff) | (dc << 16);
    r[e] = (ba >> 16) | (dc & 0xffff0000);
  }
}

void sixteenths(const uint16_t* __restrict values, int n, uint8_t* __restrict out) {
  for (int i = 0; i < n; ++i)
    out[i] = static_cast<uint8_t>(static_cast<uint16_t>(values[i] + 15) >> 4);
}

void max_into(uint8_t* __restrict target, const uint8_t* __restrict other, int n) {
  for (int i = 0; i < n; ++i) target[i] = target[i] > other[i] ? target[i] : other[i];
}

void min_max(const int32_t* __restrict values, int n, int32_t* __restrict low,
             int32_t* __restrict high) {
  int32_t l = values[0], h = values[0];
  for (int i = 1; i < n; ++i) {
    l = values[i] < l ? values[i] : l;
    h = values[i] > h ? values[i] : h;
  }
  *low = l;
  *high = h;
}

}  // namespace

extern const Kernels table;
const Kernels table = {place,       index,            block_scores,     pair_scores,
                       bound_index, bound_scores,     row_bound_scores, turned_bounds,
                       linearise,   bilinear_squares, bicubic_squares,  stamp,
                       interleave,  sixteenths,       max_into,         min_max};

}  // namespace wayfare::kernels::WAYFARE_ISA
