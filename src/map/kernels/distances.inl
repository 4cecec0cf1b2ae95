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
  typedef int32_t Half __attribute__((vector_size(64), aligned(4), may_alias));
  typedef int32_t Value __attribute__((vector_size(64)));
  Value a = *reinterpret_cast<const Half*>(squares);
  Value b = *reinterpret_cast<const Half*>(squares + 16);
  for (int k = 1; k <= kReach; ++k) {
    const int32_t square = k * k;
    if (k % 4 == 1) {
      const Value larger = a > b ? a : b;
      int32_t any = 0;
      for (int i = 0; i < 16; ++i) any |= larger[i] > square ? 1 : 0;
      if (any == 0) break;
      if (k == kReach - 3) return false;
    }
    const Half* const left = reinterpret_cast<const Half*>(squares - k);
    const Half* const right = reinterpret_cast<const Half*>(squares + k);
    const Value a0 = left[0] + square, a1 = right[0] + square;
    const Value b0 = left[1] + square, b1 = right[1] + square;
    a = a < a0 ? a : a0;
    b = b < b0 ? b : b0;
    a = a < a1 ? a : a1;
    b = b < b1 ? b : b1;
  }
  *reinterpret_cast<Half*>(out) = a;
  *reinterpret_cast<Half*>(out + 16) = b;
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
  typedef float Reals __attribute__((vector_size(64)));
  typedef int32_t Ints __attribute__((vector_size(64)));
  typedef Reals UnalignedReals __attribute__((aligned(4), may_alias));
  constexpr float kSlack = 1.41422F, kInside = 1e-3F, kNever = 1e9F;
  const Reals zero = {}, never = zero + kNever, end = zero + limit;
  const Ints none = {}, right = none + table.width, top = none + table.height;
  for (int begin = 0; begin < n; begin += 16) {
    const Reals c = *reinterpret_cast<const UnalignedReals*>(cos + begin);
    const Reals s = *reinterpret_cast<const UnalignedReals*>(sin + begin);
    const Ints level = c == zero, upright = s == zero;
    const Reals inverse_c = 1.0F / (level ? zero + 1.0F : c);
    const Reals inverse_s = 1.0F / (upright ? zero + 1.0F : s);
    // From the lower border of a cell to the next border along the ray.
    const Reals ahead_x = (c > zero ? zero + 1.0F : zero) - fx;
    const Reals ahead_y = (s > zero ? zero + 1.0F : zero) - fy;
    Reals t = zero;
    while (true) {
      const Reals x = fx + t * c, y = fy + t * s;
      Ints u = __builtin_convertvector(x, Ints), v = __builtin_convertvector(y, Ints);
      Reals low_x = __builtin_convertvector(u, Reals), low_y = __builtin_convertvector(v, Reals);
      const Ints past_x = x < low_x, past_y = y < low_y;  // −1 where rounded up
      u += past_x;
      v += past_y;
      low_x += __builtin_convertvector(past_x, Reals);
      low_y += __builtin_convertvector(past_y, Reals);
      u += ix;
      v += iy;
      u = u < -1 ? none - 1 : u;
      v = v < -1 ? none - 1 : v;
      u = u > right ? right : u;
      v = v > top ? top : v;
      const Ints at = (v + 1) * table.stride + u + 1;
      Reals d;
      for (int k = 0; k < 16; ++k) d[k] = table.distance[at[k]];
      const Ints on = (d > zero) & (t < end);
      bool any = false;
      for (int k = 0; k < 16; ++k) any |= on[k] != 0;
      // Outside the map the range is the limit.
      if (!any) {
        t = d < zero ? end : t;
        break;
      }
      const Reals tx = level ? never : (low_x + ahead_x) * inverse_c;
      const Reals ty = upright ? never : (low_y + ahead_y) * inverse_s;
      const Reals leave = tx < ty ? tx : ty;
      const Reals next = (leave > t ? leave : t) + kInside;
      const Reals jump = t + (d - kSlack);
      t = on ? (jump > next ? jump : next) : t;
    }
    *reinterpret_cast<UnalignedReals*>(cells + begin) = t < end ? t : end;
  }
}

// The cells of sixteen points at a time, then one load each: a gather is no faster.
void field_sums(const Field& field, const float* x, const float* y, int n,
                const PoseBatch& poses, uint32_t* sums) {
  typedef float Reals __attribute__((vector_size(64)));
  typedef int32_t Ints __attribute__((vector_size(64)));
  typedef Reals UnalignedReals __attribute__((aligned(4), may_alias));
  const Reals high = Reals{} + static_cast<float>(1 << 20), low = -high;
  const Ints none = {}, right = none + field.width, top = none + field.height;
  const uint16_t* const values = field.table;
  for (int p = 0; p < poses.n; ++p) {
    const float c = poses.c[p], s = poses.s[p], ox = poses.ox[p], oy = poses.oy[p];
    uint32_t even = 0, odd = 0;
    for (int i = 0; i < n; i += 16) {
      const Reals px = *reinterpret_cast<const UnalignedReals*>(x + i);
      const Reals py = *reinterpret_cast<const UnalignedReals*>(y + i);
      Reals fu = c * px - s * py + ox, fv = s * px + c * py + oy;
      fu = fu > low ? fu : low;  // NaN becomes the lowest
      fv = fv > low ? fv : low;
      fu = fu < high ? fu : high;
      fv = fv < high ? fv : high;
      Ints u = __builtin_convertvector(fu, Ints), v = __builtin_convertvector(fv, Ints);
      u += fu < __builtin_convertvector(u, Reals);  // −1 where rounded up
      v += fv < __builtin_convertvector(v, Reals);
      u = u < -1 ? none - 1 : u;
      v = v < -1 ? none - 1 : v;
      u = u > right ? right : u;
      v = v > top ? top : v;
      const Ints at = v * field.stride + u;
      int32_t cell[16];
      __builtin_memcpy(cell, &at, sizeof cell);
      for (int k = 0; k < 16; k += 2) {
        even += values[cell[k]];
        odd += values[cell[k + 1]];
      }
    }
    sums[p] = even + odd;
  }
}
