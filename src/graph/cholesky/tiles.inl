// Tiles of a matrix in registers: R vectors of kLanes rows by C columns.

namespace wayfare::cholesky::WAYFARE_ISA {
namespace {

#if defined(__AVX512F__)
constexpr int kLanes = 8, kTile = 4;
#elif defined(__AVX__)
constexpr int kLanes = 4, kTile = 2;
#else
constexpr int kLanes = 2, kTile = 2;
#endif

typedef double Lanes __attribute__((vector_size(8 * kLanes)));
typedef double LooseLanes __attribute__((vector_size(8 * kLanes), aligned(8), may_alias));

inline Lanes load(const double* p) { return *reinterpret_cast<const LooseLanes*>(p); }
inline void store(double* p, Lanes v) { *reinterpret_cast<LooseLanes*>(p) = v; }
inline Lanes all(double v) { return Lanes{} + v; }
inline double sum(Lanes v) {
  double part[kLanes];
  for (int i = 0; i < kLanes; ++i) part[i] = v[i];
  for (int half = kLanes / 2; half > 0; half /= 2)
    for (int i = 0; i < half; ++i) part[i] += part[i + half];
  return part[0];
}

template <int R>
struct Height {
  static constexpr int value = R;
};

/// op(Height<R>, row) over rows [begin, end), a multiple of kLanes, in tiles as high as possible.
template <class Op>
inline void over_rows(int begin, int end, const Op& op) {
  int i = begin;
  for (; i + kTile * kLanes <= end; i += kTile * kLanes) op(Height<kTile>{}, i);
  const int left = (end - i) / kLanes;
  if constexpr (kTile > 3)
    if (left == 3) return op(Height<3>{}, i);
  if constexpr (kTile > 2)
    if (left == 2) return op(Height<2>{}, i);
  if (left == 1) op(Height<1>{}, i);
}

template <int R, int C>
struct Tile {
  Lanes v[R][C];

  void zero() {
    for (int c = 0; c < C; ++c)
      for (int r = 0; r < R; ++r) v[r][c] = Lanes{};
  }
  void read(const double* p, long ld) {
    for (int c = 0; c < C; ++c)
      for (int r = 0; r < R; ++r) v[r][c] = load(p + c * ld + r * kLanes);
  }
  void write(double* p, long ld) const {
    for (int c = 0; c < C; ++c)
      for (int r = 0; r < R; ++r) store(p + c * ld + r * kLanes, v[r][c]);
  }
  /// this −= A Bᵀ, A with the tile's rows and B with its columns, both with `depth` columns.
  void subtract_product(const double* a, long lda, const double* b, long ldb, long depth) {
    for (const double* const end = a + depth * lda; a != end; a += lda, b += ldb) {
      Lanes x[R];
      for (int r = 0; r < R; ++r) x[r] = load(a + r * kLanes);
      for (int c = 0; c < C; ++c) {
        const Lanes s = all(b[c]);
        for (int r = 0; r < R; ++r) v[r][c] -= x[r] * s;
      }
    }
  }
  /// this += A Bᵀ, b[c * across + k * along] the coefficient of column c.
  void add_product(const double* a, long lda, const double* b, long across, long along,
                   long depth) {
    for (const double* const end = a + depth * lda; a != end; a += lda, b += along) {
      Lanes x[R];
      for (int r = 0; r < R; ++r) x[r] = load(a + r * kLanes);
      for (int c = 0; c < C; ++c) {
        const Lanes s = all(b[c * across]);
        for (int r = 0; r < R; ++r) v[r][c] += x[r] * s;
      }
    }
  }
  /// this := this L⁻ᵀ with a lower triangle of C columns, its diagonal stored as reciprocals.
  void divide_by(const double* l, long ld) {
    for (int c = 0; c < C; ++c) {
      const Lanes inverse = all(l[c * ld + c]);
      for (int r = 0; r < R; ++r) v[r][c] *= inverse;
      for (int d = c + 1; d < C; ++d) {
        const Lanes s = all(l[c * ld + d]);
        for (int r = 0; r < R; ++r) v[r][d] -= v[r][c] * s;
      }
    }
  }
};

template <int C>
struct Width {
  static constexpr int value = C;
};

/// op(Width<C>, column) over `count` columns, a multiple of N, six at a time if possible.
template <int N, class Op>
inline void over_columns(int count, const Op& op) {
  int j = 0;
  for (; j + 6 <= count; j += 6) op(Width<6>{}, j);
  if constexpr (N < 6) {
    for (; j < count; j += N) op(Width<N>{}, j);
  }
}

}  // namespace
}  // namespace wayfare::cholesky::WAYFARE_ISA
