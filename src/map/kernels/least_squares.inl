// Part of kernels.cpp: sums over the points for the least-squares matchers.

// Lanes past the end read the table's border of zeros; the sums of the lanes are added in double
// precision every 512 points.

/// Sixteen points in the field: the cell below and left of each, and the fractions beyond it.
struct FieldPoints {
  Reals x, y, fu, fv;
  Ints at;
};

[[gnu::always_inline]] inline FieldPoints placed(const float* x, const float* y,
                                                 const CellTransform& t, const Field& field,
                                                 int lanes) {
  FieldPoints p;
  p.x = Reals::loaded(x);
  p.y = Reals::loaded(y);
  Reals u = t.c * p.x - t.s * p.y + t.ox, v = t.s * p.x + t.c * p.y + t.oy;
  const Reals right = static_cast<float>(field.width + 4);
  const Reals top = static_cast<float>(field.height + 4), low = -4.0F;
  if (lanes < 16) u = chosen(less(lane_numbers(), Ints(lanes)), u, low);
  u = lesser(greater(u, low), right);
  v = lesser(greater(v, low), top);
  const Ints column = to_ints(u + 8.0F) - 8, row = to_ints(v + 8.0F) - 8;
  p.fu = u - to_reals(column);
  p.fv = v - to_reals(row);
  p.at = row * field.stride + column;
  return p;
}

/// f and its derivatives along the table's axes.
struct Samples {
  Reals f, gu, gv;
};

/// Two neighbouring cells, `offset` from each point's.
inline Ints pairs(const uint16_t* table, const Ints& at, long offset) {
  typedef int32_t Pair __attribute__((aligned(2), may_alias));
  int32_t cell[16];
  at.store(cell);
  return Ints::of([&](int j) { return *reinterpret_cast<const Pair*>(table + cell[j] + offset); });
}
inline Reals first_of(const Ints& pair) {
  return to_reals(kLittleEndian ? pair & Ints(0xffff) : pair >> 16);
}
inline Reals second_of(const Ints& pair) {
  return to_reals(kLittleEndian ? pair >> 16 : pair & Ints(0xffff));
}

// Inlined into the loops: vectors of arguments and results of a function go through memory.
struct Bilinear {
  [[gnu::always_inline]] Samples operator()(const FieldPoints& p, const Field& field) const {
    const Ints near = pairs(field.table, p.at, 0);
    const Ints far = pairs(field.table, p.at, field.stride);
    const Reals p00 = first_of(near), p10 = second_of(near);
    const Reals p01 = first_of(far), p11 = second_of(far);
    const Reals du0 = p10 - p00, du1 = p11 - p01;
    const Reals f0 = p00 + p.fu * du0, gv = p01 + p.fu * du1 - f0;
    return {f0 + p.fv * gv, du0 + p.fv * (du1 - du0), gv};
  }
};

/// Catmull-Rom weights of four neighbours at a fraction t beyond the second, and their derivatives.
struct CubicWeights {
  Reals w[4], slope[4];

  explicit CubicWeights(const Reals& t) {
    w[0] = 0.5F * t * ((2.0F - t) * t - 1.0F);
    w[1] = 0.5F * (t * t * (3.0F * t - 5.0F) + 2.0F);
    w[2] = 0.5F * t * ((4.0F - 3.0F * t) * t + 1.0F);
    w[3] = 0.5F * t * t * (t - 1.0F);
    slope[0] = 0.5F * ((4.0F - 3.0F * t) * t - 1.0F);
    slope[1] = 0.5F * t * (9.0F * t - 10.0F);
    slope[2] = 0.5F * ((8.0F - 9.0F * t) * t + 1.0F);
    slope[3] = 0.5F * t * (3.0F * t - 2.0F);
  }
};

struct Bicubic {
  [[gnu::always_inline]] Samples operator()(const FieldPoints& p, const Field& field) const {
    const CubicWeights u(p.fu), v(p.fv);
    Samples s = {};
    for (int k = 0; k < 4; ++k) {
      const long row = static_cast<long>(k - 1) * field.stride;
      const Ints left = pairs(field.table, p.at, row - 1);
      const Ints right = pairs(field.table, p.at, row + 1);
      const Reals a = first_of(left), b = second_of(left), c = first_of(right),
                  d = second_of(right);
      const Reals value = u.w[0] * a + u.w[1] * b + u.w[2] * c + u.w[3] * d;
      const Reals slope = u.slope[0] * a + u.slope[1] * b + u.slope[2] * c + u.slope[3] * d;
      s.f += v.w[k] * value;
      s.gu += v.w[k] * slope;
      s.gv += v.slope[k] * value;
    }
    return s;
  }
};

/// Calls add(f, gradient in the points' axes and about their origin, lanes, acc) for sixteen points
/// at a time; sums blocks in single precision.
template <class Sample, class Add>
inline void sum_over(const float* __restrict x, const float* __restrict y, int n,
                     const CellTransform& t, const Field& field, double* __restrict sums,
                     Sample sample, Add add) {
  const float cells = 1 / __builtin_sqrtf(t.c * t.c + t.s * t.s);
  const float c = t.c * cells, s = t.s * cells;
  for (int k = 0; k < 10; ++k) sums[k] = 0;
  for (int block = 0; block < n; block += 512) {
    const int end = n - block < 512 ? n : block + 512;
    Reals acc[10] = {};
    for (int i = block; i < end; i += 16) {
      const int lanes = end - i < 16 ? end - i : 16;
      const FieldPoints p = placed(x + i, y + i, t, field, lanes);
      const Samples f = sample(p, field);
      const Reals g0 = c * f.gu + s * f.gv, g1 = c * f.gv - s * f.gu, g2 = p.x * g1 - p.y * g0;
      add(f.f, g0, g1, g2, lanes, acc);
    }
    for (int k = 0; k < 10; ++k)
      for (int j = 0; j < 16; ++j) sums[k] += static_cast<double>(acc[k][j]);
  }
}

inline void add_outer(const Reals& w, const Reals& g0, const Reals& g1, const Reals& g2,
                      Reals* acc) {
  const Reals w0 = w * g0, w1 = w * g1;
  acc[4] += w0 * g0;
  acc[5] += w0 * g1;
  acc[6] += w0 * g2;
  acc[7] += w1 * g1;
  acc[8] += w1 * g2;
  acc[9] += w * g2 * g2;
}

void linearise(const float* __restrict x, const float* __restrict y, int n, const CellTransform& t,
               const Field& field, float a, float b, double* __restrict sums) {
  const auto add = [=](const Reals& f, const Reals& g0, const Reals& g1, const Reals& g2, int,
                       Reals* acc) {
    acc[0] += f;
    acc[1] += g0;
    acc[2] += g1;
    acc[3] += g2;
    add_outer(1.0F / (a + b * f), g0, g1, g2, acc);
  };
  sum_over(x, y, n, t, field, sums, Bilinear{}, add);
}

template <class Sample>
inline void squares(const float* __restrict x, const float* __restrict y, int n,
                    const CellTransform& t, const Field& field, float one, double* __restrict sums,
                    Sample sample) {
  const auto add = [=](const Reals& f, const Reals& g0, const Reals& g1, const Reals& g2, int lanes,
                       Reals* acc) {
    Reals r = one - f;
    if (lanes < 16) r = chosen(less(lane_numbers(), Ints(lanes)), r, Reals{});
    acc[0] += r * r;
    acc[1] += r * g0;
    acc[2] += r * g1;
    acc[3] += r * g2;
    add_outer(Reals(1.0F), g0, g1, g2, acc);
  };
  sum_over(x, y, n, t, field, sums, sample, add);
}

void bilinear_squares(const float* x, const float* y, int n, const CellTransform& t,
                      const Field& field, float one, double* sums) {
  squares(x, y, n, t, field, one, sums, Bilinear{});
}
void bicubic_squares(const float* x, const float* y, int n, const CellTransform& t,
                     const Field& field, float one, double* sums) {
  squares(x, y, n, t, field, one, sums, Bicubic{});
}
