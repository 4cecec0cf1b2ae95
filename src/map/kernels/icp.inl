// Part of kernels.cpp: nearest surface points, and sums over pairs of points and lines.

/// Map coordinates, and distances from them, whose buckets an int can name.
constexpr float kFarthest_m = 1e8F, kLongest_m = 1.5e8F;

// floor for |t| < 2³⁰.
inline int whole_below(double t) {
  const int i = static_cast<int>(t);
  return i - (t < i ? 1 : 0);
}

using Distances = Wide<float, 8>;
using Indices = Wide<int32_t, 8>;

/// In each lane the least of the distances, the first of equals, and the least of the others.
struct TwoNearest {
  Distances least, other;
  Indices index;

  void offer(const Distances& d, const Indices& at, const Indices& is_nearer) {
    other = lesser(other, chosen(is_nearer, least, d));
    least = chosen(is_nearer, d, least);
    index = chosen(is_nearer, at, index);
  }
};

/// Squares of the distances within a radius from a point.
inline TwoNearest search(const SurfaceTable& table, float px, float py, float radius) {
  // Wider than the rounding of distances.
  const double reach = static_cast<double>(radius) * (1 + 1e-6);
  const double x = static_cast<double>(px), y = static_cast<double>(py);
  const int west = whole_below((x - reach) * kBucketsPerMetre) - table.left;
  const int east = whole_below((x + reach) * kBucketsPerMetre) - table.left;
  const int south = whole_below((y - reach) * kBucketsPerMetre) - table.bottom;
  const int north = whole_below((y + reach) * kBucketsPerMetre) - table.bottom;
  const int u0 = west > 0 ? west : 0, u1 = east < table.width - 1 ? east : table.width - 1;
  const int v0 = south > 0 ? south : 0, v1 = north < table.height - 1 ? north : table.height - 1;
  const Distances limit = radius * radius;
  TwoNearest best = {limit, limit, Indices(-1)};
  if (u0 > u1) return best;
  const Indices lanes = lane_numbers<8>();
  for (int v = v0; v <= v1; ++v) {
    const uint32_t* row = table.first + static_cast<long>(v) * table.width;
    const int end = static_cast<int>(row[u1 + 1]);
    for (int i = static_cast<int>(row[u0]); i < end; i += 8) {
      const Distances dx = Distances::loaded(table.x + i) - px;
      const Distances dy = Distances::loaded(table.y + i) - py;
      const Indices at = lanes + i;
      Distances d = dx * dx + dy * dy;
      d = chosen(less(at, Indices(end)), d, limit);
      best.offer(d, at, less(d, best.least));
    }
  }
  return best;
}

/// The least lane.
template <class N>
inline N least_of(const Wide<N, 8>& v) {
  using Eight = Wide<N, 8>;
  auto least = v.piece[0];
  const auto with = [&](const auto& o) { least = o < least ? o : least; };
  if constexpr (Eight::kPieces == 1) {
    with(__builtin_shufflevector(least, least, 4, 5, 6, 7, 0, 1, 2, 3));
    with(__builtin_shufflevector(least, least, 2, 3, 0, 1, 6, 7, 4, 5));
    with(__builtin_shufflevector(least, least, 1, 0, 3, 2, 5, 4, 7, 6));
  } else {
    with(v.piece[1]);
    with(__builtin_shufflevector(least, least, 2, 3, 0, 1));
    with(__builtin_shufflevector(least, least, 1, 0, 3, 2));
  }
  return least[0];
}

inline float distance_from(const SurfaceTable& table, int point, float x, float y) {
  const float dx = table.x[point] - x, dy = table.y[point] - y;
  return __builtin_sqrtf(dx * dx + dy * dy);
}

/// Searches and remembers the nearest point of a place, and how far all others are at least.
/// Returns the nearest, −1 for none.
inline int search_from(const SurfaceTable& table, float x, float y, float bound, int i,
                       const Neighbours& known) {
  // A little farther than the nearest can be, so that the answer holds near the place too.
  constexpr float kMore_m = 0.02F;
  const TwoNearest found = search(table, x, y, bound + kMore_m);
  const Distances least = least_of(found.least);
  constexpr int32_t kNone = 0x7fffffff;
  const Indices is_least = less(Indices(-1), found.index) & equal(found.least, least);
  const int32_t first = least_of(chosen(is_least, found.index, Indices(kNone)));
  const float other =
      least_of(chosen(equal(found.index, Indices(first)), found.other, found.least));
  const int nearest = first == kNone ? -1 : first;
  known.index[i] = nearest;
  known.x[i] = x;
  known.y[i] = y;
  known.nearest_x[i] = nearest >= 0 ? table.x[nearest] : 0.0F;
  known.nearest_y[i] = nearest >= 0 ? table.y[nearest] : 0.0F;
  known.others[i] = __builtin_sqrtf(other);
  return nearest;
}

void nearest(const SurfaceTable& table, const float* __restrict x, const float* __restrict y, int n,
             float radius, const Neighbours& known, int32_t* __restrict index,
             float* __restrict squares) {
  const Reals square = radius * radius, farthest = radius < kLongest_m ? radius : kLongest_m;
  // The next search does not wait for the end of the last: its hint is from the one before that.
  int hint = -1, next_hint = -1;
  for (int i = 0; i < n; i += 16) {
    const auto at = [i](const float* p) { return Reals::loaded(p + i); };
    const auto squared_from = [&](const float* u, const float* v) {
      const Reals dx = at(x) - at(u), dy = at(y) - at(v);
      return dx * dx + dy * dy;
    };
    const auto distance_from_each = [&](const float* u, const float* v) {
      float d[16];
      squared_from(u, v).store(d);
      for (float& t : d) t = __builtin_sqrtf(t);
      return Reals::loaded(d);
    };
    const Ints last = Ints::loaded(known.index + i);
    const Reals moved = distance_from_each(known.x, known.y);
    Reals away = distance_from_each(known.nearest_x, known.nearest_y);
    away = chosen(less(last, Ints{}), Reals(radius), away);
    // Other points are at least as far as they were, less the way moved; wider than rounding.
    const Reals others = at(known.others) * 0.9999F - 1e-6F;
    int32_t holds[16];
    float bounds[16];
    less(away + moved, others).store(holds);
    lesser(away, farthest).store(bounds);
    const int lanes = n - i < 16 ? n - i : 16;
    for (int j = 0; j < lanes; ++j) {
      if (holds[j] != 0) continue;
      const float u = x[i + j], v = y[i + j];
      if (!(u > -kFarthest_m && u < kFarthest_m && v > -kFarthest_m && v < kFarthest_m)) {
        known.index[i + j] = -1;
        known.others[i + j] = 0;
        continue;
      }
      float bound = bounds[j];
      if (known.index[i + j] < 0 && hint >= 0) {
        const float d = distance_from(table, hint, u, v);
        bound = d < bound ? d : bound;
      }
      const int found = search_from(table, u, v, bound, i + j, known);
      if (found >= 0) hint = std::exchange(next_hint, found);
    }
    const Ints found = Ints::loaded(known.index + i);
    const Reals distances = squared_from(known.nearest_x, known.nearest_y);
    chosen(at_most(distances, square), found, Ints(-1)).store(index + i);
    distances.store(squares + i);
  }
}

/// ln(1 + u) for u ≥ 0, to 2e-7 of its value.
inline Reals log_one_plus(const Reals& u) {
  constexpr int32_t kRootHalf = 0x3f3504f3;
  const Ints bits = bits_of(1.0F + u);
  const Ints power = (bits - kRootHalf) >> 23;
  const Reals mantissa = of_bits(bits - (power << 23));
  const Reals f = chosen(equal(power, Ints{}), u, mantissa - 1.0F);  // exact for small u
  const Reals s = f / (2.0F + f), ss = s * s;
  const Reals series = ((ss * (1.0F / 9) + 1.0F / 7) * ss + 1.0F / 5) * ss + 1.0F / 3;
  return to_reals(power) * 0.69314718F + 2.0F * (s + s * ss * series);
}

void line_squares(const PointLines& l, const CellTransform& t, float information,
                  double* __restrict sums) {
  const auto at = [](const float* p, int i) { return Reals::loaded(p + i); };
  for (int k = 0; k < 10; ++k) sums[k] = 0;
  for (int block = 0; block < l.n; block += 512) {
    const int end = l.n - block < 512 ? l.n : block + 512;
    Reals acc[10] = {};
    for (int i = block; i < end; i += 16) {
      const Reals px = at(l.px, i), py = at(l.py, i), nx = at(l.nx, i), ny = at(l.ny, i);
      const Reals u = t.c * px - t.s * py + t.ox - at(l.qx, i);
      const Reals v = t.s * px + t.c * py + t.oy - at(l.qy, i);
      const Reals r = nx * u + ny * v, square = r * r * information;
      const Reals w = 1.0F / (1.0F + square), wr = w * r;
      const Reals g0 = t.c * nx + t.s * ny, g1 = t.c * ny - t.s * nx, g2 = px * g1 - py * g0;
      acc[0] += log_one_plus(square);
      acc[1] += wr * g0;
      acc[2] += wr * g1;
      acc[3] += wr * g2;
      add_outer(w, g0, g1, g2, acc);
    }
    for (int k = 0; k < 10; ++k)
      for (int j = 0; j < 16; ++j) sums[k] += static_cast<double>(acc[k][j]);
  }
}
