// The kernels of a search in every instruction set this CPU supports, compared with loops over the
// points.

#include <algorithm>
#

#include <gtest/gtest.h>

#include "kernel_case.hpp"

namespace wayfare {
namespace {

/// Points along a random walk, so that neighbours share units; merged, in units from −(du, dv).
struct MergedCase : KernelCase {
  int level, parts, entries = 0;
  Ints u, v, units_x, units_y, ends;
  std::vector<std::uint16_t> weight;

  MergedCase(Rng& rng, const Kernels& k, int of_level)
      : KernelCase(rng),
        level(of_level),
        parts((n + kernels::kMergedPart - 1) / kernels::kMergedPart) {
    const double stride = rng.uniform(0.001, 0.2);
    for (std::size_t i = 1; i < x.size(); ++i) {
      x[i] = (i > 1 ? x[i - 1] : 0.0F) + static_cast<float>(rng.uniform(-stride, stride));
      y[i] = y[i - 1] + static_cast<float>(rng.uniform(-stride, stride));
    }
    place(k, u, v);
    units_x.resize(x.size() + 16);
    units_y.resize(x.size() + 16);
    weight.resize(x.size() + 16);
    ends.resize(static_cast<std::size_t>(parts));
    entries = k.merge(u.data(), v.data(), n, {transform.du, transform.dv, 2 * level},
                      units_x.data(), units_y.data(), weight.data(), ends.data());
  }
  [[nodiscard]] kernels::Merged merged() const {
    return {units_x.data(), units_y.data(), weight.data(), ends.data()};
  }
  /// Indices of single cells for entries in the grid.
  [[nodiscard]] Ints index(const Kernels& k) const {
    Ints at(units_x.size());
    k.index(units_x.data(), units_y.data(), (entries + 15) / 16 * 16, 0, 0, grid.width(),
            grid.height(), grid.stride(), at.data());
    return at;
  }
};

/// Calls `body(kernels, case)` for cases of every level.
template <class Body>
void for_each_merged_case(Body&& body) {
  for_each_variant([&](const Kernels& k, const Kernels&) {
    Rng rng(27);
    for (int i = 0; i < 100; ++i) body(k, MergedCase(rng, k, i % PrecomputationGrids::kLevels));
  });
}

TEST(SearchKernels, MergeKeepsEveryPointInItsUnit) {
  int merged = 0;
  for_each_merged_case([&](const Kernels&, const MergedCase& test) {
    ASSERT_EQ(test.ends.back(), test.entries);
    merged += test.n - test.entries;
    int point = 0, entry = 0;
    for (const int end : test.ends) {
      const int first = entry, last = std::min(test.n, point + kernels::kMergedPart);
      for (; entry < end; ++entry) {
        const auto e = static_cast<std::size_t>(entry);
        ASSERT_GT(test.weight[e], 0);
        for (int i = 0; i < test.weight[e]; ++i, ++point) {
          const auto p = static_cast<std::size_t>(point);
          ASSERT_EQ(test.units_x[e], (test.u[p] + test.transform.du) >> (2 * test.level));
          ASSERT_EQ(test.units_y[e], (test.v[p] + test.transform.dv) >> (2 * test.level));
        }
        if (entry > first) {
          ASSERT_TRUE(test.units_x[e] != test.units_x[e - 1] ||
                      test.units_y[e] != test.units_y[e - 1]);
        }
      }
      ASSERT_EQ(point, last);
    }
    ASSERT_EQ(point, test.n);
  });
  EXPECT_GT(merged, 1000);
}

TEST(SearchKernels, BoundsAreSumsOverThePoints) {
  for_each_merged_case([](const Kernels& k, const MergedCase& test) {
    const auto bounds = test.bounds(test.level);
    for (const int groups : {1, 2, 4})
      for (const int ahead : {0, -16}) {
        Sums sums(64, 0);
        for (int part = 0; part < test.parts; ++part)
          k.merged_bounds(test.merged(), part, bounds, ahead, 0, groups, sums.data());
        for (int g = 0; g < 4; ++g) {
          const Sums got(sums.begin() + 16L * g, sums.begin() + 16L * (g + 1));
          ASSERT_EQ(got, g < groups ? test.bounds_of(test.level, g + ahead / 16) : Sums(16, 0));
        }
      }
  });
}

TEST(SearchKernels, PointBoundsAreSumsOverThePoints) {
  for_each_variant([](const Kernels& k, const Kernels&) {
    Rng rng(22);
    for (int i = 0; i < 100; ++i) {
      const KernelCase test(rng);
      const int level = i % PrecomputationGrids::kLevels;
      ASSERT_EQ(test.point_bounds(k, level), test.bounds_of(level));
    }
  });
}

TEST(SearchKernels, MergedCellsScoreLikeTheirPoints) {
  for_each_variant([](const Kernels& k, const Kernels& portable) {
    Rng rng(28);
    for (int i = 0; i < 100; ++i) {
      const MergedCase test(rng, k, 0);
      const Ints at = test.index(k);
      Sums pairs(16), rows(2 * kernels::kBlock);
      k.merged_pairs(test.merged(), test.parts, test.grids.pairs(), test.grid.stride(), at.data(),
                     pairs.data());
      k.merged_rows(test.merged(), test.parts, test.grid.data(), test.grid.stride(), at.data(),
                    rows.data());
      ASSERT_EQ(pairs, test.pair_scores(portable));
      ASSERT_EQ(rows, test.block_scores(portable, 2));
    }
  });
}

TEST(SearchKernels, PairsAndSquaresBoundTheirCells) {
  for_each_variant([](const Kernels& variant, const Kernels& portable) {
    Rng rng(24);
    for (int i = 0; i < 200; ++i) {
      const KernelCase test(rng);
      const Sums exact = test.block_scores(portable, 16), pairs = test.pair_scores(variant);
      const Sums squares = test.bounds_of(0);
      ASSERT_EQ(pairs, test.pair_scores(portable));
      for (unsigned y = 0; y < 16; ++y)
        for (unsigned x = 0; x < 16; ++x) {
          ASSERT_LE(exact[y * 16 + x], 16 * squares[4 * (x / 4) + y / 4]);
          if (y < 4) {
            ASSERT_LE(exact[y * 16 + x], 16 * pairs[8 * (y / 2) + x / 2]);
          }
        }
    }
  });
}

}  // namespace
}  // namespace wayfare
