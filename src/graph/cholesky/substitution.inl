// Forward and backward substitution with one right-hand side.

namespace wayfare::cholesky::WAYFARE_ISA {
namespace {

// Solves for C pivots at a time. Entries past the last pivot, up to ld11, are read and written but
// unused: y has room for them.

template <int N>
inline void copy_block(const double* __restrict from, double* __restrict to) {
  for (int i = 0; i < N; ++i) to[i] = from[i];
}

template <int N>
void gather(const int* index, int count, const double* from, double* to) {
  for (int i = 0; i < count; ++i) copy_block<N>(from + static_cast<long>(index[i]) * N, to + i * N);
}

template <int N>
void forward(const Panel& f, int first, const int* rows, double* __restrict all_of_y,
             double* __restrict scratch) {
  double* __restrict const t = scratch;
  double* __restrict const y = scratch + f.ld21;
  for (int i = 0; i < f.pivots; ++i) y[i] = all_of_y[first * N + i];
  over_columns<N>(f.pivots, [&](auto width, int k) {
    constexpr int C = decltype(width)::value;
    const double* const l = f.l11 + static_cast<long>(k) * f.ld11;
    double x[C];
    for (int c = 0; c < C; ++c) {
      x[c] = y[k + c];
      for (int d = 0; d < c; ++d) x[c] -= l[d * f.ld11 + k + c] * x[d];
      x[c] *= l[c * f.ld11 + k + c];
      y[k + c] = x[c];
    }
    int i = k + C;
    for (; i < f.ld11 && i % kLanes != 0; ++i)
      for (int c = 0; c < C; ++c) y[i] -= l[c * f.ld11 + i] * x[c];
    for (; i < f.ld11; i += kLanes) {
      Lanes v = load(y + i);
      for (int c = 0; c < C; ++c) v -= load(l + c * f.ld11 + i) * all(x[c]);
      store(y + i, v);
    }
  });
  over_rows(0, f.ld21, [&](auto height, int i) {
    Tile<decltype(height)::value, 1> tile;
    tile.zero();
    const double* l = f.l21 + i;
    for (int k = 0; k < f.pivots; ++k, l += f.ld21) {
      const Lanes s = all(y[k]);
      for (int r = 0; r < decltype(height)::value; ++r) tile.v[r][0] += load(l + r * kLanes) * s;
    }
    tile.write(t + i, 0);
  });
  for (int i = 0; i < f.pivots; ++i) all_of_y[first * N + i] = y[i];
  for (int i = 0; i < f.rows / N; ++i) {
    double* __restrict const to = all_of_y + static_cast<long>(rows[i]) * N;
    for (int k = 0; k < N; ++k) to[k] -= t[i * N + k];
  }
}

/// dot_c += Σ l(i, c) x_i over rows [begin, end), in whole vectors.
template <int C>
inline void add_dots(const double* l, long ld, int begin, int end, const double* x,
                     Lanes (&dot)[C]) {
  for (int i = begin; i < end; i += kLanes) {
    const Lanes v = load(x + i);
    for (int c = 0; c < C; ++c) dot[c] += load(l + c * ld + i) * v;
  }
}

template <int C>
inline void backward_columns(const Panel& f, int k, double* __restrict y,
                             const double* __restrict t) {
  const double* const l = f.l11 + static_cast<long>(k) * f.ld11;
  const int next = k + C, whole = (next + kLanes - 1) / kLanes * kLanes;
  Lanes dot[C] = {};
  add_dots<C>(f.l21 + static_cast<long>(k) * f.ld21, f.ld21, 0, f.ld21, t, dot);
  add_dots<C>(l, f.ld11, whole, f.ld11, y, dot);
  double x[C];
  for (int c = 0; c < C; ++c) x[c] = y[k + c] - sum(dot[c]);
  for (int i = next; i < whole && i < f.pivots; ++i)
    for (int c = 0; c < C; ++c) x[c] -= l[c * f.ld11 + i] * y[i];
  for (int c = C - 1; c >= 0; --c) {
    x[c] *= l[c * f.ld11 + k + c];
    for (int d = 0; d < c; ++d) x[d] -= l[d * f.ld11 + k + c] * x[c];
  }
  for (int c = 0; c < C; ++c) y[k + c] = x[c];
}

template <int N>
void backward(const Panel& f, int first, const int* rows, double* __restrict all_of_y,
              double* __restrict scratch) {
  double* __restrict const t = scratch;
  double* __restrict const y = scratch + f.ld21;
  gather<N>(rows, f.rows / N, all_of_y, t);
  for (int i = f.rows; i < f.ld21; ++i) t[i] = 0.0;
  for (int i = 0; i < f.pivots; ++i) y[i] = all_of_y[first * N + i];
  for (int i = f.pivots; i < f.ld11; ++i) y[i] = 0.0;
  int k = f.pivots;
  // As over_columns, from the end.
  if constexpr (N < 6) {
    for (; k % 6 != 0; k -= N) backward_columns<N>(f, k - N, y, t);
  }
  for (; k > 0; k -= 6) backward_columns<6>(f, k - 6, y, t);
  for (int i = 0; i < f.pivots; ++i) all_of_y[first * N + i] = y[i];
}

}  // namespace
}  // namespace wayfare::cholesky::WAYFARE_ISA
