// What a front begins with: blocks of H and the updates of its children.

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
        for (int r = 0; r < N; ++r) to[c * ld + r] += from[r * N + c];
    } else {
      for (int c = 0; c < N; ++c)
        for (int r = 0; r < N; ++r) to[c * ld + r] += from[c * N + r];
    }
  }
}

/// to += from, N columns of `rows` numbers, a multiple of N.
template <int N>
inline void add_columns(double* __restrict to, long ld_to, const double* __restrict from,
                        long ld_from, int rows) {
  for (int c = 0; c < N; ++c) {
    double* const a = to + c * ld_to;
    const double* const b = from + c * ld_from;
    int i = 0;
    for (; i + kLanes <= rows; i += kLanes) store(a + i, load(a + i) + load(b + i));
    for (; i < rows; ++i) a[i] += b[i];
  }
}

/// Block columns of run `a` at and below the diagonal: its own rows, then those of the runs after
/// it up to `end`.
template <int N>
inline void add_run(const Update& u, int a, int end, double* to, int ld) {
  const Run run = u.runs[a];
  for (int j = 0; j < run.length; ++j) {
    const double* const from = u.values + static_cast<long>(run.from + j) * N * u.ld;
    double* const column = to + static_cast<long>(run.to + j) * N * ld;
    add_columns<N>(column + (run.to + j) * N, ld, from + (run.from + j) * N, u.ld,
                   (run.length - j) * N);
    for (int b = a + 1; b < end; ++b) {
      const Run& rows = u.runs[b];
      add_columns<N>(column + rows.to * N, ld, from + rows.from * N, u.ld, rows.length * N);
    }
  }
}

template <int N>
void add_to_panel(const Update& u, const Panel& f) {
  for (int a = 0; a < u.pivot_runs; ++a) {
    add_run<N>(u, a, u.pivot_runs, f.l11, f.ld11);
    const Run run = u.runs[a];
    for (int j = 0; j < run.length; ++j) {
      const double* const from = u.values + static_cast<long>(run.from + j) * N * u.ld;
      double* const column = f.l21 + static_cast<long>(run.to + j) * N * f.ld21;
      for (int b = u.pivot_runs; b < u.all_runs; ++b) {
        const Run& rows = u.runs[b];
        add_columns<N>(column + rows.to * N, f.ld21, from + rows.from * N, u.ld, rows.length * N);
      }
    }
  }
}

template <int N>
void add_to_update(const Update& u, double* update, int ld) {
  for (int a = u.pivot_runs; a < u.all_runs; ++a) add_run<N>(u, a, u.all_runs, update, ld);
}

}  // namespace
}  // namespace wayfare::cholesky::WAYFARE_ISA
