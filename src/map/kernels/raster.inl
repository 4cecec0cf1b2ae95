// Part of kernels.cpp: what a scan passes of a tile of 64×64 cells.

// As many as a register contains, at most a part.
constexpr int kCountBytes = kRegister < 32 ? kRegister : 32, kCounts = kCountBytes / 2;
typedef int16_t Counts __attribute__((vector_size(kCountBytes)));
typedef Counts CountsInMemory __attribute__((aligned(2), may_alias));

constexpr Counts kNoCounts = {};

// F()(lane) in each lane.
template <class F>
constexpr Counts counts_of(F) {
  return []<std::size_t... J>(std::index_sequence<J...>) {
    return Counts{static_cast<int16_t>(F()(static_cast<int>(J)))...};
  }
  (std::make_index_sequence<kCounts>());
}
// Lane F()(lane) of v in each lane.
template <class F>
inline Counts lanes_from(Counts v, F) {
  return [&]<std::size_t... J>(std::index_sequence<J...>) {
    return __builtin_shufflevector(v, v, F()(static_cast<int>(J))...);
  }
  (std::make_index_sequence<kCounts>());
}
// Lanes moved up within groups of four.
inline Counts moved_up(Counts v, int lanes) {
  typedef uint64_t Groups __attribute__((vector_size(kCountBytes)));
  const auto groups = reinterpret_cast<Groups>(v);
  return reinterpret_cast<Counts>(kLittleEndian ? groups << (16 * lanes) : groups >> (16 * lanes));
}
// Sums of the lanes up to each: within groups of four first, then of eight, then across.
inline Counts running_sums(Counts v) {
  constexpr Counts kOddGroups = counts_of([](int j) { return -(j / 4 % 2); });
  constexpr Counts kUpperHalf = counts_of([](int j) { return -(j / 8); });
  v += moved_up(v, 1);
  v += moved_up(v, 2);
  v += kOddGroups & lanes_from(v, [](int j) { return j / 8 * 8 + 3; });
  return kCounts == 8 ? v : v + (kUpperHalf & lanes_from(v, [](int) { return 7; }));
}
inline Counts last_of(Counts v) {
  return lanes_from(v, [](int) { return kCounts - 1; });
}
constexpr Counts kLaneBits = counts_of([](int j) { return 1 << j; });

// −1 in the lanes of the bits that are set.
inline Counts lanes_of(uint64_t bits) {
  const Counts all = kNoCounts + static_cast<int16_t>(bits);
  return (all & kLaneBits) == kLaneBits;
}
// The bits of the lanes that are not zero.
inline uint64_t bits_of(Counts v) {
  const Counts bits = (v != kNoCounts) & kLaneBits;
  uint64_t words[kCountBytes / 8], any = 0;
  __builtin_memcpy(words, &bits, sizeof words);
  for (const uint64_t w : words) any |= w;
  any |= any >> 32;
  return (any | any >> 16) & 0xffff;
}

template <int kParts>
TileExtent count_passes_of(const TileDifferences<int16_t>& d, uint16_t* __restrict passes) {
  constexpr int kVectors = 16 * kParts / kCounts;
  const int first_part = d.first_part, n_rows = d.rows;
  const long stride = d.stride, hit_stride = stride / kTileSide;
  int16_t* __restrict rows = d.along_rows;
  int16_t* __restrict steps = d.along_columns;
  int16_t* __restrict row_sums = d.row_sums;
  const uint64_t* __restrict hits = d.hits;
  Counts columns[kVectors], any[kVectors] = {};
  CountsInMemory* sums = reinterpret_cast<CountsInMemory*>(d.column_sums);
  for (int i = 0; i < kVectors; ++i) columns[i] = sums[i];
  for (int r = 0; r < n_rows; ++r, rows += stride, steps += stride, hits += hit_stride) {
    CountsInMemory* row = reinterpret_cast<CountsInMemory*>(rows);
    CountsInMemory* step = reinterpret_cast<CountsInMemory*>(steps);
    CountsInMemory* out = reinterpret_cast<CountsInMemory*>(passes + r * kTileSide);
    const uint64_t hit = *hits >> (16 * first_part);
    Counts before = kNoCounts + row_sums[r];
    for (int i = 0; i < kVectors; ++i) {
      const Counts along = running_sums(row[i]);
      columns[i] += step[i];
      row[i] = kNoCounts;
      step[i] = kNoCounts;
      const Counts n = (along + before + columns[i]) & ~lanes_of(hit >> (kCounts * i));
      before += last_of(along);
      out[i] = n;
      any[i] |= n;
    }
    row_sums[r] = before[0];
  }
  for (int i = 0; i < kVectors; ++i) sums[i] = columns[i];
  TileExtent extent;
  for (int i = 0; i < kVectors; ++i)
    extent.columns |= bits_of(any[i]) << (16 * first_part + kCounts * i);
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
  constexpr int kPerPart = 16 / kCounts;
  for (int r = 0; r < rows; ++r) {
    CountsInMemory* row = reinterpret_cast<CountsInMemory*>(cells + r * kTileSide);
    for (int i = first_part * kPerPart; i < (first_part + parts) * kPerPart; ++i) {
      const Counts old = row[i], marked = lanes_of(bits[r] >> (kCounts * i));
      Counts l = old & (old != unknown);
      l = l < low ? low : l;
      l = l > high ? high : l;
      l += step;
      row[i] = (l & marked) | (old & ~marked);
    }
  }
}
