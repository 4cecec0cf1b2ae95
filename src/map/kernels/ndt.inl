// Part of kernels.cpp: sums over the normal distributions at points.

inline Reals floor_of(const Reals& t) {
  const Reals whole = __builtin_convertvector(__builtin_convertvector(t, Ints), Reals);
  return whole - __builtin_convertvector((t < whole) & 1, Reals);
}

/// exp(−q/2) for q ≥ 0, to 2e-7 of its value; 0 ≤ q ≤ 160 in effect.
inline Reals gaussian(const Reals& q) {
  const Reals most = Reals{} + 160.0F;
  const Reals y = -0.72134752F * (q < most ? q : most);  // log₂ e / 2
  const Ints whole = __builtin_convertvector(y - 0.5F, Ints);
  const Reals f = 0.69314718F * (y - __builtin_convertvector(whole, Reals));
  Reals p = f * (1.0F / 720) + 1.0F / 120;
  p = p * f + 1.0F / 24;
  p = p * f + 1.0F / 6;
  p = p * f + 0.5F;
  p = p * f + 1.0F;
  p = p * f + 1.0F;
  return p * reinterpret_cast<Reals>((whole + 127) << 23);
}

void ndt_sums(const float* __restrict x, const float* __restrict y, int n, const CellTransform& t,
              const NdtTable& table, double* __restrict sums) {
  const int stride = table.width + 2;
  for (int k = 0; k < 10; ++k) sums[k] = 0;
  for (int block = 0; block < n; block += 256) {
    const int end = n - block < 256 ? n : block + 256;
    Reals acc[10] = {};
    for (int i = block; i < end; i += 16) {
      const Reals px = *reinterpret_cast<const LooseReals*>(x + i);
      const Reals py = *reinterpret_cast<const LooseReals*>(y + i);
      const Reals ru = t.c * px - t.s * py, rv = t.s * px + t.c * py;
      const int lanes = end - i < 16 ? end - i : 16;
      Reals likelihood = {}, s0 = {}, s1 = {}, suu = {}, suv = {}, svv = {};
      for (int tiling = 0; tiling < 4; ++tiling) {
        const Reals limit = Reals{} + t.limit;
        Reals u = ru + (t.ox + 0.5F * static_cast<float>(tiling & 1));
        Reals v = rv + (t.oy + 0.5F * static_cast<float>(tiling >> 1));
        u = u < limit ? u : limit;
        u = u > -limit ? u : -limit;
        v = v < limit ? v : limit;
        v = v > -limit ? v : -limit;
        const Reals left = floor_of(u), low = floor_of(v);
        Ints column = __builtin_convertvector(left, Ints) + (t.du + 1);
        Ints row = __builtin_convertvector(low, Ints) + (t.dv + 1);
        column = column > 0 ? column : 0;
        column = column < table.width + 1 ? column : table.width + 1;
        row = row > 0 ? row : 0;
        row = row < table.height + 1 ? row : table.height + 1;
        const Ints at = row * stride + column;
        Reals mu = {}, mv = {}, uu = {}, uv = {}, vv = {}, known = {};
        for (int j = 0; j < lanes; ++j) {
          const float* d = table.distributions + 8L * table.places[tiling][at[j]];
          mu[j] = d[0];
          mv[j] = d[1];
          uu[j] = d[2];
          uv[j] = d[3];
          vv[j] = d[4];
          known[j] = d[5];
        }
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
