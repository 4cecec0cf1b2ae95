// Part of kernels.cpp: construction of the tables.

void stamp(uint16_t* __restrict target, int stride, const uint16_t* __restrict kernel, int width,
           int rows) {
  for (int r = 0; r < rows; ++r) {
    for (int b = 0; b < width; b += 16) {
      for (int c = b; c < b + 16; ++c) target[c] = target[c] > kernel[c] ? target[c] : kernel[c];
    }
    target += stride;
    kernel += width;
  }
}

// Transposes the 4×4 bytes of every four 32-bit words.
void interleave(const uint8_t* const* rows, int entries, uint8_t* const* out) {
  typedef uint32_t Word __attribute__((aligned(1), may_alias));
  const auto little = [](uint32_t w) { return kLittleEndian ? w : __builtin_bswap32(w); };
  const Word* in[4];
  Word* to[4];
  for (int j = 0; j < 4; ++j) {
    in[j] = reinterpret_cast<const Word*>(rows[j]);
    to[j] = reinterpret_cast<Word*>(out[j]);
  }
  const Word* __restrict a = in[0], * __restrict b = in[1], * __restrict c = in[2], * __restrict d = in[3];
  Word* __restrict o = to[0], * __restrict p = to[1], * __restrict q = to[2], * __restrict r = to[3];
  for (int e = 0; e < entries; ++e) {
    const uint32_t first = little(a[e]), second = little(b[e]), third = little(c[e]),
                   fourth = little(d[e]);
    const uint32_t ab = (first & 0x00ff00ff) | ((second & 0x00ff00ff) << 8);
    const uint32_t cd = (third & 0x00ff00ff) | ((fourth & 0x00ff00ff) << 8);
    const uint32_t ba = ((first >> 8) & 0x00ff00ff) | (second & 0xff00ff00);
    const uint32_t dc = ((third >> 8) & 0x00ff00ff) | (fourth & 0xff00ff00);
    o[e] = little((ab & 0xffff) | (cd << 16));
    q[e] = little((ab >> 16) | (cd & 0xffff0000));
    p[e] = little((ba & 0xffff) | (dc << 16));
    r[e] = little((ba >> 16) | (dc & 0xffff0000));
  }
}

void sixteenths(const uint16_t* __restrict values, int n, uint8_t* __restrict out) {
  for (int i = 0; i < n; ++i)
    out[i] = static_cast<uint8_t>(static_cast<uint16_t>(values[i] + 15) >> 4);
}

void max_into(uint8_t* __restrict target, const uint8_t* __restrict other, int n) {
  for (int i = 0; i < n; ++i) target[i] = target[i] > other[i] ? target[i] : other[i];
}

void min_max(const int32_t* __restrict values, int n, int32_t* __restrict low,
             int32_t* __restrict high) {
  int32_t l = values[0], h = values[0];
  for (int i = 1; i < n; ++i) {
    l = values[i] < l ? values[i] : l;
    h = values[i] > h ? values[i] : h;
  }
  *low = l;
  *high = h;
}
