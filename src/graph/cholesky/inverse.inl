// The blocks of Z = H⁻¹ in L's pattern, front by front from the roots down. With Z₂₂ known and V =
// −L₂₁ L₁₁⁻¹: Z₂₁ = Z₂₂ V, Z₁₁ = L₁₁⁻ᵀ L₁₁⁻¹ + Vᵀ Z₂₁ (Takahashi, Fagan, Chin 1973; in fronts
// Campbell, Davis 1995, "Computing the sparse inverse subset: an inverse multifrontal approach").

namespace wayfare::cholesky::WAYFARE_ISA {
namespace {

/// w (p×p) := L₁₁⁻ᵀ: zeros below the diagonal, except inside tiles.
template <int N>
void invert_pivots(const Panel& f, double* __restrict w, long ld) {
  for (long i = 0; i < ld * f.pivots; ++i) w[i] = 0.0;
  for (int i = 0; i < f.pivots; ++i) w[i * ld + i] = 1.0;
  over_rows(0, padded(f.pivots), [&](auto height, int i) {
    over_columns<N>(f.pivots, [&](auto width, int k) {
      constexpr int C = decltype(width)::value;
      if (k + C <= i) return;
      Tile<decltype(height)::value, C> tile;
      tile.read(w + i + k * ld, ld);
      tile.subtract_product(w + i, ld, f.l11 + k, f.ld11, k);
      tile.divide_by(f.l11 + static_cast<long>(k) * f.ld11 + k, f.ld11);
      tile.write(w + i + k * ld, ld);
    });
  });
}

/// vt = Vᵀ (p×m); z.l21 temporarily stores −V = L₂₁ L₁₁⁻¹.
template <int N>
void find_v(const Panel& f, const Panel& z, const double* w, double* __restrict vt, long ld) {
  over_rows(0, f.ld21, [&](auto height, int i) {
    over_columns<N>(f.pivots, [&](auto width, int k) {
      Tile<decltype(height)::value, decltype(width)::value> tile;
      tile.zero();
      tile.subtract_product(f.l21 + i + static_cast<long>(k) * f.ld21, f.ld21, w + k + k * ld, ld,
                            f.pivots - k);
      tile.write(z.l21 + i + static_cast<long>(k) * z.ld21, z.ld21);
    });
  });
  for (int k = 0; k < f.pivots; ++k)
    for (int i = 0; i < f.rows; ++i) vt[i * ld + k] = z.l21[static_cast<long>(k) * z.ld21 + i];
}

template <int N>
void invert(const Panel& f, const Panel& z, const double* z22, double* scratch) {
  const int p = f.pivots;
  const long ld = padded(p);
  double* const w = scratch;
  double* const z11 = w + ld * p;
  double* const vt = z11 + ld * p;
  invert_pivots<N>(f, w, ld);
  if (f.rows > 0) {
    find_v<N>(f, z, w, vt, ld);
    over_columns<N>(p, [&](auto width, int k) {
      over_rows(0, f.ld21, [&](auto height, int i) {
        Tile<decltype(height)::value, decltype(width)::value> tile;
        tile.zero();
        tile.add_product(z22 + i, f.ld21, vt + k, 1, ld, f.rows);
        tile.write(z.l21 + i + static_cast<long>(k) * z.ld21, z.ld21);
      });
    });
  }
  over_columns<N>(p, [&](auto width, int k) {
    over_rows(k / kPad * kPad, padded(p), [&](auto height, int i) {
      Tile<decltype(height)::value, decltype(width)::value> tile;
      tile.zero();
      // Rows of L₁₁⁻ᵀ begin at its diagonal; those past the last pivot are undefined.
      const int diagonal = i > k ? i : k, from = diagonal < p ? diagonal : p;
      tile.add_product(w + i + from * ld, ld, w + k + from * ld, 1, ld, p - from);
      tile.add_product(vt + i, ld, z.l21 + static_cast<long>(k) * z.ld21, z.ld21, 1, f.rows);
      tile.write(z11 + i + k * ld, ld);
    });
  });
  for (int k = 0; k < p; ++k) {
    for (int i = k; i < p; ++i) {
      const double v = z11[k * ld + i];
      z.l11[static_cast<long>(k) * z.ld11 + i] = v;
      z.l11[static_cast<long>(i) * z.ld11 + k] = v;
    }
  }
}

/// to := from, or its transpose if rows and columns of `from` are exchanged.
inline void copy_rectangle(double* __restrict to, long ld_to, const double* __restrict from,
                           long ld_from, int rows, int columns) {
  for (int c = 0; c < columns; ++c, to += ld_to, from += ld_from)
    for (int r = 0; r < rows; ++r) to[r] = from[r];
}
inline void copy_transposed(double* __restrict to, long ld_to, const double* __restrict from,
                            long ld_from, int rows, int columns) {
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns; ++c) to[c * ld_to + r] = from[r * ld_from + c];
}

/// Gathers the child's Z₂₂ from its parent's Z₁₁, Z₂₁ and Z₂₂.
template <int N>
void gather_inverse(const Update& child, const Panel& z, const double* z22, double* child_z22) {
  for (int a = 0; a < child.all_runs; ++a) {
    const Run columns = child.runs[a];
    const int width = columns.length * N;
    const long c = static_cast<long>(columns.to) * N;
    for (int b = 0; b < child.all_runs; ++b) {
      const Run rows = child.runs[b];
      const int height = rows.length * N;
      const long r = static_cast<long>(rows.to) * N;
      double* const to = child_z22 + static_cast<long>(columns.from) * N * child.ld + rows.from * N;
      const bool column_is_pivot = a < child.pivot_runs, row_is_pivot = b < child.pivot_runs;
      if (column_is_pivot && row_is_pivot) {
        copy_rectangle(to, child.ld, z.l11 + c * z.ld11 + r, z.ld11, height, width);
      } else if (column_is_pivot) {
        copy_rectangle(to, child.ld, z.l21 + c * z.ld21 + r, z.ld21, height, width);
      } else if (row_is_pivot) {
        copy_transposed(to, child.ld, z.l21 + r * z.ld21 + c, z.ld21, height, width);
      } else {
        copy_rectangle(to, child.ld, z22 + c * z.ld21 + r, z.ld21, height, width);
      }
    }
  }
}

}  // namespace
}  // namespace wayfare::cholesky::WAYFARE_ISA
