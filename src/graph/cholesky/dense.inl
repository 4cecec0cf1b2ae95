// Partial Cholesky factorisation of a front.

namespace wayfare::cholesky::WAYFARE_ISA {
namespace {

// Range of values with a finite reciprocal.
constexpr double kSmallest = 2.2250738585072014e-308, kLargest = 1.7976931348623157e308;

/// Cholesky of C×C in place, the diagonal stored as reciprocals. Returns the pivot that is not
/// positive or not finite, or −1. The elimination uses a_rc a_dc / a_cc, so that the square roots
/// are off the critical path.
template <int C>
inline int factorise_corner(double* __restrict l, int ld) {
  double a[C][C], inverse[C];
  for (int c = 0; c < C; ++c)
    for (int r = c; r < C; ++r) a[c][r] = l[c * ld + r];
  for (int c = 0; c < C; ++c) {
    if (!(a[c][c] >= kSmallest && a[c][c] <= kLargest)) return c;
    inverse[c] = 1.0 / a[c][c];
    for (int d = c + 1; d < C; ++d) {
      const double s = a[c][d] * inverse[c];
      for (int r = d; r < C; ++r) a[d][r] -= s * a[c][r];
    }
  }
  for (int c = 0; c < C; ++c) {
    const double root = __builtin_sqrt(inverse[c]);
    l[c * ld + c] = root;
    for (int r = c + 1; r < C; ++r) l[c * ld + r] = a[c][r] * root;
  }
  return -1;
}

// Left-looking, a few columns at a time. Tiles begin at multiples of kLanes, so those at the
// diagonal also cover entries above it, which are not read.
template <int N>
int factorise_pivots(const Panel& f) {
  const int p = f.pivots, ld = f.ld11;
  double* const l = f.l11;
  int failed = -1;
  over_columns<N>(p, [&](auto width, int k) {
    constexpr int C = decltype(width)::value;
    if (failed >= 0) return;
    double* const columns = l + static_cast<long>(k) * ld;
    const int top = k / kPad * kPad;
    const int corner_end = padded(k + C) < ld ? padded(k + C) : ld;
    const auto look_left = [&](auto height, int i) {
      Tile<decltype(height)::value, C> tile;
      tile.read(columns + i, ld);
      tile.subtract_product(l + i, ld, l + k, ld, k);
      tile.write(columns + i, ld);
    };
    if (k > 0) over_rows(top, corner_end, look_left);
    const int bad = factorise_corner<C>(columns + k, ld);
    if (bad >= 0) failed = k + bad;
    if (bad >= 0 || k + C == p) return;
    for (int i = k + C; i < corner_end; ++i) {
      for (int c = 0; c < C; ++c) {
        double v = columns[c * ld + i];
        for (int d = 0; d < c; ++d) v -= columns[d * ld + i] * columns[d * ld + k + c];
        columns[c * ld + i] = v * columns[c * ld + k + c];
      }
    }
    over_rows(corner_end, ld, [&](auto height, int i) {
      Tile<decltype(height)::value, C> tile;
      tile.read(columns + i, ld);
      tile.subtract_product(l + i, ld, l + k, ld, k);
      tile.divide_by(columns + k, ld);
      tile.write(columns + i, ld);
    });
  });
  return failed;
}

/// L₂₁ := A₂₁ L₁₁⁻ᵀ, by tiles of rows.
template <int N>
void solve_rows(const Panel& f) {
  const long ld = f.ld21;
  over_rows(0, f.ld21, [&](auto height, int i) {
    constexpr int R = decltype(height)::value;
    double* const rows = f.l21 + i;
    over_columns<N>(f.pivots, [&](auto width, int k) {
      Tile<R, decltype(width)::value> tile;
      tile.read(rows + k * ld, ld);
      tile.subtract_product(rows, ld, f.l11 + k, f.ld11, k);
      tile.divide_by(f.l11 + static_cast<long>(k) * f.ld11 + k, f.ld11);
      tile.write(rows + k * ld, ld);
    });
  });
}

template <int N>
int factorise(const Panel& f) {
  const int failed = factorise_pivots<N>(f);
  if (failed < 0) solve_rows<N>(f);
  return failed;
}

template <int N>
void update(const Panel& f, double* __restrict u, int ldu) {
  const long ld = f.ld21;
  over_columns<N>(f.rows, [&](auto width, int j) {
    double* const columns = u + static_cast<long>(j) * ldu;
    over_rows(j / kPad * kPad, f.ld21, [&](auto height, int i) {
      Tile<decltype(height)::value, decltype(width)::value> tile;
      tile.zero();
      tile.subtract_product(f.l21 + i, ld, f.l21 + j, ld, f.pivots);
      tile.write(columns + i, ldu);
    });
  });
}

}  // namespace
}  // namespace wayfare::cholesky::WAYFARE_ISA
