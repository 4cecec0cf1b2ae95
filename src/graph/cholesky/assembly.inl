// Assembly of a front: blocks of H and the updates of its children.

namespace wayfare::cholesky::WAYFARE_ISA {
namespace {

template <int N>
void scatter(const Placement* placements, int count, const double* h, const Panel& f) {
  for (int i = 0; i < count; ++i) {
    const Placement& p = placements[i];
    const long ld = p.below ? f.ld21 : f.ld11;
    double* __restrict to = (p.below ? f.l21 : f.l11) + p.column * N * ld + p.row * N;
    const double* __restrict from = h + static_cast<long>(p.block) * (N * N);
    if (p.transposed) {
      for (int c = 0; c < N; ++c)
        for (int r = 0; r < N; ++r) to[c * ld + r] = from[r * N + c];
    } else {
      for (int c = 0; c < N; ++c)
        for (int r = 0; r < N; ++r) to[c * ld + r] = from[c * N + r];
    }
  }
}

/// to += from over `columns` columns of `Step` rows.
template <int Step>
inline void add_strip(double* __restrict to, long ld_to, const double* __restrict from,
                      long ld_from, int columns) {
  typedef double Strip __attribute__((vector_size(8 * Step), aligned(8), may_alias));
  for (int c = 0; c < columns; ++c, to += ld_to, from += ld_from)
    *reinterpret_cast<Strip*>(to) += *reinterpret_cast<const Strip*>(from);
}

/// to += from.
inline void add_rectangle(double* __restrict to, long ld_to, const double* __restrict from,
                          long ld_from, int rows, int columns) {
  int i = 0;
  for (; i + 8 <= rows; i += 8) add_strip<8>(to + i, ld_to, from + i, ld_from, columns);
  if ((rows & 4) != 0) add_strip<4>(to + i, ld_to, from + i, ld_from, columns), i += 4;
  if ((rows & 2) != 0) add_strip<2>(to + i, ld_to, from + i, ld_from, columns), i += 2;
  if ((rows & 1) != 0) add_strip<1>(to + i, ld_to, from + i, ld_from, columns);
}

/// Block columns of run `a`, rows of runs [begin, end), all below it.
template <int N>
inline void add_below(const Update& u, int a, int begin, int end, double* to, int ld) {
  const Run columns = u.runs[a];
  const double* const from = u.values + static_cast<long>(columns.from) * N * u.ld;
  double* const first = to + static_cast<long>(columns.to) * N * ld;
  for (int b = begin; b < end; ++b) {
    const Run rows = u.runs[b];
    add_rectangle(first + rows.to * N, ld, from + rows.from * N, u.ld, rows.length * N,
                  columns.length * N);
  }
}

/// Block columns of run `a` at and below the diagonal, rows of runs up to `end`.
template <int N>
inline void add_run(const Update& u, int a, int end, double* to, int ld) {
  const Run run = u.runs[a];
  for (int j = 0; j < run.length; ++j) {
    const int i = run.from + j, k = run.to + j;
    add_rectangle(to + static_cast<long>(k) * N * ld + k * N, ld,
                  u.values + static_cast<long>(i) * N * u.ld + i * N, u.ld, (run.length - j) * N,
                  N);
  }
  add_below<N>(u, a, a + 1, end, to, ld);
}

template <int N>
void add_to_panel(const Update& u, const Panel& f) {
  for (int a = 0; a < u.pivot_runs; ++a) {
    add_run<N>(u, a, u.pivot_runs, f.l11, f.ld11);
    add_below<N>(u, a, u.pivot_runs, u.all_runs, f.l21, f.ld21);
  }
}

template <int N>
void add_to_update(const Update& u, double* update, int ld) {
  for (int a = u.pivot_runs; a < u.all_runs; ++a) add_run<N>(u, a, u.all_runs, update, ld);
}

}  // namespace
}  // namespace wayfare::cholesky::WAYFARE_ISA
