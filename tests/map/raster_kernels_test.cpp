// The raster kernels of every instruction set this CPU supports, compared with loops over cells.

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/detail/isa.hpp>
#include <wayfare/core/random.hpp>

#include "map/kernels/kernels.hpp"

namespace wayfare::kernels {
namespace {

constexpr std::size_t kSide = kTileSide;

template <class Check>
void for_each_supported(const Check& check) {
  for (const Isa isa : {Isa::baseline, Isa::avx2, Isa::avx512})
    if (runs_here(isa)) check(kernels_for(isa));
}

/// A bit that is set with probability p.
std::uint64_t random_bits(Rng& rng, double p) {
  std::uint64_t bits = 0;
  for (int i = 0; i < 64; ++i) bits |= std::uint64_t{rng.uniform() < p} << i;
  return bits;
}

TEST(RasterKernels, CountPassesSumsTheDifferences) {
  for_each_supported([](const Kernels& k) {
    Rng rng(1);
    for (int round = 0; round < 300; ++round) {
      const int rows = 1 + static_cast<int>(rng.below(64));
      const int first_part = static_cast<int>(rng.below(4));
      const int parts = 1 + static_cast<int>(rng.below(4 - first_part));
      const auto columns = static_cast<std::size_t>(16 * parts),
                 height = static_cast<std::size_t>(rows);
      // Passes are small and not negative where the sums left and below are large.
      const auto any = [&](unsigned reach) {
        return static_cast<std::int16_t>(static_cast<int>(rng.below(2 * reach + 1)) -
                                         static_cast<int>(reach));
      };
      std::vector<std::int16_t> along_rows(128 * height), along_columns(128 * height);
      std::array<std::int16_t, kSide> row_sums{}, column_sums{};
      for (auto& v : row_sums) v = static_cast<std::int16_t>(500 + any(300));
      for (auto& v : column_sums) v = static_cast<std::int16_t>(500 + any(300));
      std::vector<std::uint64_t> hits(2 * height);
      for (auto& word : hits) word = random_bits(rng, 0.1);
      for (std::size_t r = 0; r < height; ++r)
        for (std::size_t c = 0; c < columns; ++c) {
          along_rows[128 * r + c] = any(2);
          along_columns[128 * r + c] = any(2);
        }
      const bool is_empty = round % 10 == 0;
      if (is_empty) std::fill(hits.begin(), hits.end(), ~std::uint64_t{0});
      std::vector<std::uint16_t> want(kSide * height);
      auto row = row_sums, column = column_sums;
      TileExtent extent;
      for (std::size_t r = 0; r < height; ++r)
        for (std::size_t c = 0; c < columns; ++c) {
          const std::size_t in_tile = c + 16 * static_cast<std::size_t>(first_part);
          row[r] = static_cast<std::int16_t>(row[r] + along_rows[128 * r + c]);
          column[c] = static_cast<std::int16_t>(column[c] + along_columns[128 * r + c]);
          const int n = (hits[2 * r] >> in_tile & 1) != 0 ? 0 : row[r] + column[c];
          want[kSide * r + c] = static_cast<std::uint16_t>(n);
          if (n == 0) continue;
          extent.rows |= std::uint64_t{1} << r;
          extent.columns |= std::uint64_t{1} << in_tile;
        }
      std::vector<std::uint16_t> got(want.size());
      const TileExtent found =
          k.count_passes({along_rows.data(), along_columns.data(), 128, rows, parts, first_part,
                          row_sums.data(), column_sums.data(), hits.data()},
                         got.data());
      ASSERT_EQ(got, want);
      ASSERT_EQ(row_sums, row);
      ASSERT_EQ(column_sums, column);
      ASSERT_EQ(found.columns, extent.columns);
      ASSERT_EQ(found.rows == 0, is_empty);
      if (!is_empty) {
        // Rows between the first and the last need not be told.
        ASSERT_EQ(std::countr_zero(found.rows), std::countr_zero(extent.rows));
        ASSERT_EQ(std::countl_zero(found.rows), std::countl_zero(extent.rows));
      }
      ASSERT_EQ(std::count(along_rows.begin(), along_rows.end(), 0), 128 * rows);
      ASSERT_EQ(std::count(along_columns.begin(), along_columns.end(), 0), 128 * rows);
    }
  });
}

TEST(RasterKernels, CellsChangeAsOftenAsPassed) {
  constexpr std::int16_t kUnknown = -32768;
  for_each_supported([](const Kernels& k) {
    Rng rng(2);
    for (int round = 0; round < 200; ++round) {
      const auto high = static_cast<std::int16_t>(1 + rng.below(20'000));
      const auto low = static_cast<std::int16_t>(-1 - static_cast<int>(rng.below(12'000)));
      const int size = 1 + static_cast<int>(rng.below(12'000));
      const auto step = static_cast<std::int16_t>(round % 2 == 0 ? size : -size);
      const int most = std::min((high - low + size - 1) / size, 1 + static_cast<int>(rng.below(9)));
      const int rows = 1 + static_cast<int>(rng.below(64));
      const int part = static_cast<int>(rng.below(4)), parts = 4 - part;
      std::vector<std::int16_t> cells(kSide * kSide), want;
      for (auto& l : cells)
        l = rng.uniform() < 0.3
                ? kUnknown
                : static_cast<std::int16_t>(low + static_cast<int>(rng.below(
                                                      static_cast<std::uint64_t>(high - low + 1))));
      std::vector<std::uint16_t> passes(cells.size());
      for (auto& n : passes)
        n = static_cast<std::uint16_t>(rng.uniform() < 0.4 ? 0 : rng.below(900));
      std::vector<std::uint64_t> bits(kSide);
      for (auto& word : bits) word = random_bits(rng, 0.5);
      const PassUpdate update{step, low, high, kUnknown, static_cast<std::int16_t>(most)};
      const auto expect = [&](const auto& passes_of) {
        want = cells;
        for (std::size_t r = 0; r < static_cast<std::size_t>(rows); ++r)
          for (auto c = static_cast<std::size_t>(16 * part); c < kSide; ++c) {
            const int n = std::min(passes_of(r, c), most);
            std::int16_t& l = want[kSide * r + c];
            for (int i = 0; i < n; ++i)
              l = static_cast<std::int16_t>(
                  std::clamp<int>((l == kUnknown ? 0 : l) + step, low, high));
          }
      };
      expect([&](std::size_t r, std::size_t c) { return int{passes[kSide * r + c]}; });
      k.add_passes(cells.data() + 16 * part, passes.data() + 16 * part, rows, parts, update);
      ASSERT_EQ(cells, want);
      expect([&](std::size_t r, std::size_t c) { return static_cast<int>(bits[r] >> c & 1); });
      k.add_marks(cells.data(), bits.data(), rows, part, parts, update);
      ASSERT_EQ(cells, want);
    }
  });
}

}  // namespace
}  // namespace wayfare::kernels
