// Part of kernels.cpp: sums over the normal distributions at points.

inline Reals floor_of(const Reals& t) {
  const Reals whole = to_reals(to_ints(t));
  return whole + to_reals(less(t, whole));
}

/// exp(−q/2) for q ≥ 0, to 2e-7 of its value; 0 ≤ q ≤ 160 in effect.
inline Reals gaussian(const Reals& q) {
  const Reals y = -0.72134752F * lesser(q, Reals(160.0F));  // log₂ e / 2
  const Ints whole = to_ints(y - 0.5F);
  const Reals f = 0.69314718F * (y - to_reals(whole));
  Reals p = f * (1.0F / 720) + 1.0F / 120;
  p = p * f + 1.0F / 24;
  p = p * f + 1.0F / 6;
  p = p * f + 0.5F;
  p = p * f + 1.0F;
  p = p * f + 1.0F;
  return p * of_bits((whole + 127) << 23);
}

void ndt_sums(const float* __restrict x, const float* __restrict y, int n, const CellTransform& t,
              const NdtTable& table, double* __restrict sums) {
  const int stride = table.width + 2;
  const Ints right = table.width + 1, top = table.height + 1;
  for (int k = 0; k < 10; ++k) sums[k] = 0;
  for (int block = 0; block < n; block += 256) {
    const int end = n - block < 256 ? n : block + 256;
    Reals acc[10] = {};
    for (int i = block; i < end; i += 16) {
      const Reals px = Reals::loaded(x + i);
      const Reals py = Reals::loaded(y + i);
      const Reals ru = t.c * px - t.s * py, rv = t.s * px + t.c * py;
      const int lanes = end - i < 16 ? end - i : 16;
      Reals likelihood = {}, s0 = {}, s1 = {}, suu = {}, suv = {}, svv = {};
      for (int tiling = 0; tiling < 4; ++tiling) {
        const Reals limit = t.limit;
        Reals u = ru + (t.ox + 0.5F * static_cast<float>(tiling & 1));
        Reals v = rv + (t.oy + 0.5F * static_cast<float>(tiling >> 1));
        u = greater(lesser(u, limit), -limit);
        v = greater(lesser(v, limit), -limit);
        const Reals left = floor_of(u), low = floor_of(v);
        const Ints column = lesser(greater(to_ints(left) + (t.du + 1), Ints{}), right);
        const Ints row = lesser(greater(to_ints(low) + (t.dv + 1), Ints{}), top);
        const Ints at = row * stride + column;
        int32_t square[16];
        at.store(square);
        const float* d[16];
        for (int j = 0; j < 16; ++j)
          d[j] = table.distributions + (j < lanes ? 8L * table.places[tiling][square[j]] : 0);
        const auto value = [&d](int k) { return Reals::of([&d, k](int j) { return d[j][k]; }); };
        const Reals mu = value(0), mv = value(1), uu = value(2), uv = value(3);
        const Reals vv = value(4), known = value(5);
        const Reals du = u - left - mu, dv = v - low - mv;
        const Reals pu = uu * du + uv * dv, pv = uv * du + vv * dv;
        const Reals e = known * gaussian(du * pu + dv * pv);
        likelihood += e;
        s0 += e * pu;
        s1 += e * pv;
        suu += e * uu;
        suv += e * uv;
        svv += e * vv;
      }
      const Reals hu = suv * ru - suu * rv, hv = svv * ru - suv * rv;
      acc[0] += likelihood;
      acc[1] += s0;
      acc[2] += s1;
      acc[3] += s1 * ru - s0 * rv;
      acc[4] += suu;
      acc[5] += suv;
      acc[6] += svv;
      acc[7] += hu;
      acc[8] += hv;
      acc[9] += hv * ru - hu * rv;
    }
    for (int k = 0; k < 10; ++k)
      for (int j = 0; j < 16; ++j) sums[k] += static_cast<double>(acc[k][j]);
  }
}
