// Part of kernels.cpp: points in the same cell share one look-up.

// First the start of each entry, without branches, then the entries.
int merge(const int32_t* __restrict u, const int32_t* __restrict v, int n, const MergedUnit& unit,
          int32_t* __restrict x, int32_t* __restrict y, uint16_t* __restrict weight,
          int32_t* __restrict ends) {
  int32_t a[kMergedPart + 1], b[kMergedPart + 1], fresh[kMergedPart];
  int32_t begins[kMergedPart + 1];
  int out = 0;
  for (int begin = 0; begin < n; begin += kMergedPart) {
    const int count = n - begin < kMergedPart ? n - begin : kMergedPart;
    a[0] = b[0] = 0;
    for (int i = 0; i < count; ++i) {
      a[i + 1] = (u[begin + i] + unit.du) >> unit.shift;
      b[i + 1] = (v[begin + i] + unit.dv) >> unit.shift;
    }
    for (int i = 0; i < count; ++i)
      fresh[i] = static_cast<int32_t>(a[i + 1] != a[i]) | static_cast<int32_t>(b[i + 1] != b[i]);
    fresh[0] = 1;
    int entries = 0;
    for (int i = 0; i < count; ++i) {
      begins[entries] = i;  // kept only if the point is fresh
      entries += fresh[i];
    }
    begins[entries] = count;
    for (int j = 0; j < entries; ++j) {
      x[out + j] = a[begins[j] + 1];
      y[out + j] = b[begins[j] + 1];
      weight[out + j] = static_cast<uint16_t>(begins[j + 1] - begins[j]);
    }
    out += entries;
    *ends++ = out;
  }
  return out;
}

// A part's total weight times a byte fits 16 bits.
template <int kGroups>
inline void add_bounds(const uint8_t* __restrict table, const int32_t* __restrict at,
                       const uint16_t* __restrict weight, int n, uint32_t* __restrict sums) {
  constexpr int kAtOnce = kGroups == 4 ? 2 : 1;  // two fill a register of AVX-512
  using Groups = Wide<uint16_t, 16 * kAtOnce>;
  Groups acc[kGroups / kAtOnce];
  for (int i = 0; i < n; ++i)
    for (int g = 0; g < kGroups / kAtOnce; ++g)
      acc[g] += weight[i] * Groups::widened(table + at[i] + 16 * kAtOnce * g);
  for (int g = 0; g < kGroups / kAtOnce; ++g) add_to(sums + 16 * kAtOnce * g, acc[g]);
}

void merged_bounds(const Merged& m, int part, const BoundTable& b, int dx, int dy, int groups,
                   uint32_t* sums) {
  const int first = part == 0 ? 0 : m.ends[part - 1], n = m.ends[part] - first;
  const uint16_t* weight = m.weight + first;
  int32_t at[kMergedPart];
  bound_index(m.x + first, m.y + first, (n + 15) / 16 * 16, dx, dy, 0, b.width, b.height, b.columns,
              at);
  if (groups == 1)
    add_bounds<1>(b.table, at, weight, n, sums);
  else if (groups == 2)
    add_bounds<2>(b.table, at, weight, n, sums);
  else
    add_bounds<4>(b.table, at, weight, n, sums);
}

void merged_pairs(const Merged& m, int parts, const uint8_t* __restrict table, int stride,
                  const int32_t* __restrict at, uint32_t* __restrict sums) {
  for (int k = 0; k < 16; ++k) sums[k] = 0;
  int i = 0;
  for (int part = 0; part < parts; ++part) {
    EightSums low = {}, high = {};
    for (; i < m.ends[part]; ++i) {
      const uint8_t* p = table + at[i];
      low += m.weight[i] * even_bytes(p);
      high += m.weight[i] * even_bytes(p + 2L * stride);
    }
    for (int c = 0; c < 8; ++c) {
      sums[c] += low[c];
      sums[8 + c] += high[c];
    }
  }
}

void merged_rows(const Merged& m, int parts, const uint16_t* __restrict table, int stride,
                 const int32_t* __restrict at, uint32_t* __restrict sums) {
  Sums row[2];
  for (int i = 0; i < m.ends[parts - 1]; ++i) {
    const uint16_t* p = table + at[i];
    for (int r = 0; r < 2; ++r)
      row[r] += m.weight[i] * Sums::widened(p + static_cast<long>(r) * stride);
  }
  for (int r = 0; r < 2; ++r) row[r].store(sums + r * kBlock);
}
