// Part of kernels.cpp: what a scan passes of a tile of 64×64 cells.

typedef int16_t Counts __attribute__((vector_size(32)));
typedef Counts CountsInMemory __attribute__((aligned(2), may_alias));

constexpr Counts kNoCounts = {};

// Sums of the lanes up to each: within halves of a vector first, then across.
inline Counts running_sums(Counts v) {
  v += __builtin_shufflevector(kNoCounts, v, 0, 16, 17, 18, 19, 20, 21, 22, 8, 24, 25, 26, 27, 28,
                               29, 30);
  v += __builtin_shufflevector(kNoCounts, v, 0, 1, 16, 17, 18, 19, 20, 21, 8, 9, 24, 25, 26, 27, 28,
                               29);
  v += __builtin_shufflevector(kNoCounts, v, 0, 1, 2, 3, 16, 17, 18, 19, 8, 9, 10, 11, 24, 25, 26,
                               27);
  return v + __builtin_shufflevector(kNoCounts, v, 0, 1, 2, 3, 4, 5, 6, 7, 23, 23, 23, 23, 23, 23,
                                     23, 23);
}
inline Counts last_of(Counts v) {
  return __builtin_shufflevector(v, v, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15,
                                 15);
}
// −1 in the lanes of the bits that are set.
inline Counts lanes_of(uint64_t bits) {
  constexpr Counts kBits = {1,   2,   4,    8,    16,   32,   64,    128,
                            256, 512, 1024, 2048, 4096, 8192, 16384, -32768};
  const Counts all = kNoCounts + static_cast<int16_t>(bits);
  return (all & kBits) == kBits;
}

template <int kParts>
TileExtent count_passes_of(const TileDifferences<int16_t>& d, uint16_t* __restrict passes) {
  const int first_part = d.first_part, n_rows = d.rows;
  const long stride = d.stride, hit_stride = stride / kTileSide;
  int16_t* __restrict rows = d.along_rows;
  int16_t* __restrict steps = d.along_columns;
  int16_t* __restrict row_sums = d.row_sums;
  const uint64_t* __restrict hits = d.hits;
  Counts columns[kParts], any[kParts] = {};
  CountsInMemory* sums = reinterpret_cast<CountsInMemory*>(d.column_sums);
  for (int i = 0; i < kParts; ++i) columns[i] = sums[i];
  for (int r = 0; r < n_rows; ++r, rows += stride, steps += stride, hits += hit_stride) {
    CountsInMemory* row = reinterpret_cast<CountsInMemory*>(rows);
    CountsInMemory* step = reinterpret_cast<CountsInMemory*>(steps);
    CountsInMemory* out = reinterpret_cast<CountsInMemory*>(passes + r * kTileSide);
    const uint64_t hit = *hits >> (16 * first_part);
    Counts before = kNoCounts + row_sums[r];
    for (int i = 0; i < kParts; ++i) {
      const Counts along = running_sums(row[i]);
      columns[i] += step[i];
      row[i] = kNoCounts;
      step[i] = kNoCounts;
      const Counts n = (along + before + columns[i]) & ~lanes_of(hit >> (16 * i));
      before += last_of(along);
      out[i] = n;
      any[i] |= n;
    }
    row_sums[r] = before[0];
  }
  for (int i = 0; i < kParts; ++i) sums[i] = columns[i];
  TileExtent extent;
  for (int c = 0; c < 16 * kParts; ++c)
    extent.columns |= static_cast<uint64_t>(any[c / 16][c % 16] != 0) << c;
  extent.columns <<= 16 * first_part;
  if (extent.columns == 0) return extent;
  const auto is_empty = [&](int r) {
    uint16_t sum = 0;
    for (int c = 0; c < 16 * kParts; ++c)
      sum = static_cast<uint16_t>(sum | passes[r * kTileSide + c]);
    return sum == 0;
  };
  int bottom = 0, top = n_rows - 1;
  while (is_empty(bottom)) ++bottom;
  while (is_empty(top)) --top;
  extent.rows = uint64_t{1} << bottom | uint64_t{1} << top;
  return extent;
}

TileExtent count_passes(const TileDifferences<int16_t>& d, uint16_t* passes) {
  constexpr decltype(&count_passes_of<1>) kByParts[] = {count_passes_of<1>, count_passes_of<2>,
                                                        count_passes_of<3>, count_passes_of<4>};
  return kByParts[d.parts - 1](d, passes);
}

template <bool kUp>
inline void add_passes(int16_t* __restrict cells, const uint16_t* __restrict passes, int parts,
                       const PassUpdate& update) {
  const int16_t max = update.max_passes, unknown = update.unknown;
  const int16_t low = update.low, high = update.high;
  const auto step = static_cast<int16_t>(kUp ? update.step : -update.step);
  for (int i = 0; i < 16 * parts; ++i) {
    const int16_t old = cells[i], count = static_cast<int16_t>(passes[i]);
    const auto sum = static_cast<int16_t>((count < max ? count : max) * step);
    int16_t l = old == unknown ? int16_t{0} : old;
    // Clamped before the addition, so that the sum fits 16 bits.
    if constexpr (kUp) {
      const auto limit = static_cast<int16_t>(high - sum);
      l = static_cast<int16_t>((l < limit ? l : limit) + sum);
    } else {
      const auto limit = static_cast<int16_t>(low + sum);
      l = static_cast<int16_t>((l > limit ? l : limit) - sum);
    }
    cells[i] = count != 0 ? l : old;
  }
}

void add_passes(int16_t* cells, const uint16_t* passes, int rows, int parts,
                const PassUpdate& update) {
  for (int r = 0; r < rows; ++r, cells += kTileSide, passes += kTileSide) {
    if (update.step > 0)
      add_passes<true>(cells, passes, parts, update);
    else
      add_passes<false>(cells, passes, parts, update);
  }
}

void add_marks(int16_t* cells, const uint64_t* __restrict bits, int rows, int first_part, int parts,
               const PassUpdate& update) {
  const Counts low = kNoCounts + static_cast<int16_t>(update.low - update.step);
  const Counts high = kNoCounts + static_cast<int16_t>(update.high - update.step);
  const Counts step = kNoCounts + update.step, unknown = kNoCounts + update.unknown;
  for (int r = 0; r < rows; ++r) {
    CountsInMemory* row = reinterpret_cast<CountsInMemory*>(cells + r * kTileSide);
    for (int i = first_part; i < first_part + parts; ++i) {
      const Counts old = row[i], marked = lanes_of(bits[r] >> (16 * i));
      Counts l = old & (old != unknown);
      l = l < low ? low : l;
      l = l > high ? high : l;
      l += step;
      row[i] = (l & marked) | (old & ~marked);
    }
  }
}
