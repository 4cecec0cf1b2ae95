// Forward and backward substitution with one right-hand side.

namespace wayfare::cholesky::WAYFARE_ISA {
namespace {

template <int N>
void forward(const Panel& f, double* __restrict y, double* __restrict t) {
  for (int k = 0; k < f.pivots; ++k) {
    const double* const l = f.l11 + static_cast<long>(k) * f.ld11;
    y[k] *= l[k];
    for (int i = k + 1; i < f.pivots; ++i) y[i] -= l[i] * y[k];
  }
  over_rows(0, f.ld21, [&](auto height, int i) {
    Tile<decltype(height)::value, 1> tile;
    tile.zero();
    const double* rows = f.l21 + i;
    for (int k = 0; k < f.pivots; ++k, rows += f.ld21) {
      const Lanes s = all(y[k]);
      for (int r = 0; r < decltype(height)::value; ++r) tile.v[r][0] += load(rows + r * kLanes) * s;
    }
    tile.write(t + i, 0);
  });
}

template <int N>
void backward(const Panel& f, double* __restrict y, const double* __restrict t) {
  over_columns<N>(f.pivots, [&](auto width, int k) {
    constexpr int C = decltype(width)::value;
    const double* const columns = f.l21 + static_cast<long>(k) * f.ld21;
    Lanes dot[C] = {};
    for (int i = 0; i < f.ld21; i += kLanes) {
      const Lanes x = load(t + i);
      for (int c = 0; c < C; ++c) dot[c] += load(columns + c * static_cast<long>(f.ld21) + i) * x;
    }
    for (int c = 0; c < C; ++c) y[k + c] -= sum(dot[c]);
  });
  for (int k = f.pivots - 1; k >= 0; --k) {
    const double* const l = f.l11 + static_cast<long>(k) * f.ld11;
    double v = y[k];
    for (int i = k + 1; i < f.pivots; ++i) v -= l[i] * y[i];
    y[k] = v * l[k];
  }
}

}  // namespace
}  // namespace wayfare::cholesky::WAYFARE_ISA
