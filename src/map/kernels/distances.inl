// Part of kernels.cpp: distance fields, ray casting and the scores of many poses.

void column_step(const uint8_t* __restrict occupied, const uint16_t* __restrict before,
                 uint16_t* __restrict here, int n) {
  for (int i = 0; i < n; ++i) {
    const uint16_t next = static_cast<uint16_t>(before[i] + 1);
    const uint16_t near = next < kFarCells ? next : kFarCells;
    here[i] = occupied[i] != 0 ? uint16_t{0} : near;
  }
}

void column_back(const uint16_t* __restrict after, uint16_t* __restrict here, int n) {
  for (int i = 0; i < n; ++i) {
    const uint16_t next = static_cast<uint16_t>(after[i] + 1);
    here[i] = here[i] < next ? here[i] : next;
  }
}

// A cell k columns away is at a squared distance of at least k², so a block is finished once k²
// reaches the largest of its minima.
bool block_minimum(const int32_t* __restrict squares, int32_t* __restrict out) {
  Ints a = Ints::loaded(squares), b = Ints::loaded(squares + 16);
  for (int k = 1; k <= kReach; ++k) {
    const int32_t square = k * k;
    if (k % 4 == 1) {
      if (!any_of(less(Ints(square), greater(a, b)))) break;
      if (k == kReach - 3) return false;
    }
    const auto at = [=](int column) { return Ints::loaded(squares + column) + square; };
    a = lesser(lesser(a, at(-k)), at(k));
    b = lesser(lesser(b, at(16 - k)), at(16 + k));
  }
  a.store(out);
  b.store(out + 16);
  return true;
}

bool row_minimum(const uint16_t* column, int n, int32_t* scratch, int32_t* out) {
  const int length = 2 * kReach + (n + kRowBlock - 1) / kRowBlock * kRowBlock;
  for (int i = 0; i < kReach; ++i) scratch[i] = kFarSquared;
  for (int i = 0; i < n; ++i) {
    const int32_t cells = column[i];
    scratch[kReach + i] = cells * cells;
  }
  for (int i = kReach + n; i < length; ++i) scratch[i] = kFarSquared;
  for (int x = 0; x < n; x += kRowBlock)
    if (!block_minimum(scratch + kReach + x, out + x)) return false;
  return true;
}

// Sphere tracing that never oversteps: p is within √½ of its cell's centre and an obstacle's border
// within √½ of its own cell's centre, so d − √2 cells are free about p. If that is too small, the
// ray advances to the next cell as in exact traversal. The thousandth of a cell added ensures that
// it is inside that cell despite rounding.
void cast(const RayTable& table, int ix, int iy, float fx, float fy, const float* cos,
          const float* sin, int n, float limit, float* cells) {
  constexpr float kSlack = 1.41422F, kInside = 1e-3F, kNever = 1e9F;
  const Reals zero = {}, one = 1.0F, never = kNever, end = limit;
  const Ints below = -1, right = table.width, top = table.height;
  for (int begin = 0; begin < n; begin += 16) {
    const Reals c = Reals::loaded(cos + begin);
    const Reals s = Reals::loaded(sin + begin);
    const Ints level = equal(c, zero), upright = equal(s, zero);
    const Reals inverse_c = 1.0F / chosen(level, one, c);
    const Reals inverse_s = 1.0F / chosen(upright, one, s);
    // From the lower border of a cell to the next border along the ray.
    const Reals ahead_x = chosen(less(zero, c), one, zero) - fx;
    const Reals ahead_y = chosen(less(zero, s), one, zero) - fy;
    Reals t = zero;
    while (true) {
      const Reals x = fx + t * c, y = fy + t * s;
      Ints u = to_ints(x), v = to_ints(y);
      Reals low_x = to_reals(u), low_y = to_reals(v);
      const Ints past_x = less(x, low_x), past_y = less(y, low_y);  // −1 where rounded up
      u += past_x;
      v += past_y;
      low_x += to_reals(past_x);
      low_y += to_reals(past_y);
      u += ix;
      v += iy;
      u = lesser(greater(u, below), right);
      v = lesser(greater(v, below), top);
      const Ints at = (v + 1) * table.stride + u + 1;
      int32_t cell[16];
      at.store(cell);
      const Reals d = Reals::of([&](int k) { return table.distance[cell[k]]; });
      const Ints on = less(zero, d) & less(t, end);
      // Outside the map the range is the limit.
      if (!any_of(on)) {
        t = chosen(less(d, zero), end, t);
        break;
      }
      const Reals tx = chosen(level, never, (low_x + ahead_x) * inverse_c);
      const Reals ty = chosen(upright, never, (low_y + ahead_y) * inverse_s);
      const Reals next = greater(lesser(tx, ty), t) + kInside;
      t = chosen(on, greater(t + (d - kSlack), next), t);
    }
    lesser(t, end).store(cells + begin);
  }
}

// The cells of sixteen points at a time, then one load each: a gather is no faster.
void field_sums(const Field& field, const float* x, const float* y, int n, const PoseBatch& poses,
                uint32_t* sums) {
  const Reals high = static_cast<float>(1 << 20), low = -high;
  const Ints below = -1, right = field.width, top = field.height;
  const uint16_t* const values = field.table;
  for (int p = 0; p < poses.n; ++p) {
    const float c = poses.c[p], s = poses.s[p], ox = poses.ox[p], oy = poses.oy[p];
    uint32_t even = 0, odd = 0;
    for (int i = 0; i < n; i += 16) {
      const Reals px = Reals::loaded(x + i);
      const Reals py = Reals::loaded(y + i);
      Reals fu = c * px - s * py + ox, fv = s * px + c * py + oy;
      fu = lesser(greater(fu, low), high);  // NaN becomes the lowest
      fv = lesser(greater(fv, low), high);
      Ints u = to_ints(fu), v = to_ints(fv);
      u += less(fu, to_reals(u));  // −1 where rounded up
      v += less(fv, to_reals(v));
      u = lesser(greater(u, below), right);
      v = lesser(greater(v, below), top);
      const Ints at = v * field.stride + u;
      int32_t cell[16];
      at.store(cell);
      for (int k = 0; k < 16; k += 2) {
        even += values[cell[k]];
        odd += values[cell[k + 1]];
      }
    }
    sums[p] = even + odd;
  }
}
