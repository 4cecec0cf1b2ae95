#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/map/distance_field.hpp>

#include "map/kernels/kernels.hpp"

namespace wayfare {
namespace {

struct Mask {
  int width = 0, height = 0;
  std::vector<std::uint8_t> cells;

  [[nodiscard]] bool at(int x, int y) const {
    return x >= 0 && y >= 0 && x < width && y < height &&
           cells[static_cast<std::size_t>(y * width + x)] != 0;
  }
};

Mask random_mask(Rng& rng, int width, int height, double density) {
  Mask mask{width, height, std::vector<std::uint8_t>(static_cast<std::size_t>(width * height))};
  for (auto& c : mask.cells) c = rng.uniform() < density ? 1 : 0;
  return mask;
}

DistanceField field_of(const Mask& m, double resolution_m = 0.05, const Cell& origin = {}) {
  auto field = DistanceField::of_mask(m.cells, m.width, m.height, resolution_m, origin);
  EXPECT_TRUE(field) << field.error().message;
  return *field;
}

// The definition: every cell against every occupied one.
std::int32_t nearest(const Mask& m, const std::vector<Cell>& occupied, int x, int y) {
  std::int32_t best = DistanceField::kFar;
  for (const Cell& c : occupied)
    best = std::min(best, (c.x - x) * (c.x - x) + (c.y - y) * (c.y - y));
  return m.cells.empty() ? 0 : best;
}

void expect_exact(const Mask& m) {
  std::vector<Cell> occupied;
  for (int y = 0; y < m.height; ++y)
    for (int x = 0; x < m.width; ++x)
      if (m.at(x, y)) occupied.push_back({x, y});
  const DistanceField field = field_of(m);
  for (int y = 0; y < m.height; ++y)
    for (int x = 0; x < m.width; ++x)
      ASSERT_EQ(field.squared_cells({x, y}), nearest(m, occupied, x, y))
          << x << ", " << y << " of " << m.width << " x " << m.height;
}

TEST(DistanceField, EqualsItsDefinitionExactly) {
  Rng rng(1);
  for (int run = 0; run < 60; ++run) {
    const int w = 1 + static_cast<int>(rng.below(100)), h = 1 + static_cast<int>(rng.below(60));
    expect_exact(random_mask(rng, w, h, std::pow(10.0, -rng.uniform(0.0, 3.0))));
  }
}

// Obstacles farther than kReach: rows by the lower envelope, alone and among near obstacles.
TEST(DistanceField, IsExactWhereObstaclesAreFar) {
  Rng rng(2);
  for (int run = 0; run < 6; ++run) {
    Mask m = random_mask(rng, 700 + static_cast<int>(rng.below(40)), 40, 0.0);
    for (int k = 0; k < 1 + run; ++k) m.cells[rng.below(m.cells.size())] = 1;
    expect_exact(m);
  }
  Mask column = random_mask(rng, 3, 900, 0.0);
  column.cells[3 * 450 + 1] = 1;
  expect_exact(column);
}

TEST(DistanceField, IsFarEverywhereIfNothingIsOccupied) {
  Rng rng(1);
  const DistanceField field = field_of(random_mask(rng, 50, 20, 0.0));
  EXPECT_EQ(field.squared_cells({7, 3}), DistanceField::kFar);
  EXPECT_EQ(field.distance_m({7, 3}), std::numeric_limits<double>::infinity());
}

TEST(DistanceField, KeepsItsOrigin) {
  OccupancyGrid grid({.resolution_m = 0.1});
  for (int x = -40; x <= 40; ++x) grid.update({x, 5}, LogOdds::from_probability(0.2));
  grid.update({-40, 5}, LogOdds::from_probability(0.98));
  const auto field = DistanceField::of_grid(grid);
  ASSERT_TRUE(field);
  EXPECT_EQ(field->distance_m({-40, 5}), 0.0);
  EXPECT_NEAR(field->distance_m({-10, 5}), 3.0, 1e-12);
  EXPECT_EQ(field->squared_cells({0, 6}), DistanceField::kFar);  // outside
}

TEST(DistanceField, ReportsInvalidInput) {
  const std::vector<std::uint8_t> cells(6);
  EXPECT_FALSE(DistanceField::of_mask(cells, 2, 2, 0.05));
  EXPECT_FALSE(DistanceField::of_mask(cells, 3, 2, 0.0));
  EXPECT_FALSE(DistanceField::of_mask(cells, 3, 2, std::nan("")));
  EXPECT_FALSE(DistanceField::of_mask({}, 0, 0, 0.05));
  EXPECT_FALSE(DistanceField::of_mask({}, 30000, 30000, 0.05));
  EXPECT_FALSE(DistanceField::of_grid(OccupancyGrid()));
}

TEST(DistanceLikelihood, EqualsItsFormulaToHalfAStep) {
  Rng rng(3);
  const DistanceField field = field_of(random_mask(rng, 80, 50, 0.01), 0.05, {-7, 9});
  const DistanceLikelihood model{.sigma_m = 0.12, .floor_probability = 0.03};
  const auto grid = likelihood_field(field, model);
  ASSERT_TRUE(grid);
  for (int y = 9; y < 59; ++y)
    for (int x = -7; x < 73; ++x) {
      const double d = field.distance_m({x, y}) / model.sigma_m;
      const double expected = std::log(0.03 + 0.97 * std::exp(-0.5 * d * d));
      ASSERT_NEAR(grid->log_likelihood({x, y}), expected, 0.5001 * grid->log_step());
    }
}

// Amanatides and Woo in double precision: where the ray enters the first occupied cell, and the
// smallest distance to a cell's corner before that.
struct Hit {
  double cells = 0.0;
  double corner = std::numeric_limits<double>::infinity();
};
Hit traverse(const Mask& m, double x, double y, double c, double s, double limit) {
  int u = static_cast<int>(std::floor(x)), v = static_cast<int>(std::floor(y));
  Hit hit;
  while (hit.cells < limit) {
    if (u < 0 || v < 0 || u >= m.width || v >= m.height) break;
    if (m.at(u, v)) return hit;
    const double tx = c == 0.0 ? 1e18 : (u + (c > 0.0 ? 1 : 0) - x) / c;
    const double ty = s == 0.0 ? 1e18 : (v + (s > 0.0 ? 1 : 0) - y) / s;
    hit.corner = std::min(hit.corner, std::abs(tx - ty));
    hit.cells = std::min(tx, ty);
    if (tx < ty) {
      u += c > 0.0 ? 1 : -1;
    } else {
      v += s > 0.0 ? 1 : -1;
    }
  }
  hit.cells = limit;
  return hit;
}

struct Fan {
  std::vector<float> cosines, sines;
};
Fan fan(int n) {
  Fan f;
  for (int i = 0; i < n; ++i) {
    const double bearing = 2.0 * std::numbers::pi * i / n;
    f.cosines.push_back(static_cast<float>(std::cos(bearing)));
    f.sines.push_back(static_cast<float>(std::sin(bearing)));
  }
  return f;
}

// A ray that misses every corner by more than the added step must end in the same cell, so the
// ranges agree to that step. Rays through a corner may differ.
TEST(RayCaster, EqualsExactTraversal) {
  Rng rng(4);
  const double r = 0.05;
  int rays = 0, slipped = 0;
  for (int run = 0; run < 40; ++run) {
    const int w = 20 + static_cast<int>(rng.below(300)), h = 20 + static_cast<int>(rng.below(200));
    const Mask m = random_mask(rng, w, h, std::pow(10.0, -rng.uniform(1.0, 3.5)));
    const Cell origin{-50, 70};
    const RayCaster caster(field_of(m, r, origin));
    const Fan f = fan(181);
    std::vector<float> ranges(f.cosines.size());
    const double x = rng.uniform(0.0, w), y = rng.uniform(0.0, h);
    const SE2d pose((x + origin.x) * r, (y + origin.y) * r, Angle::radians(rng.uniform(-3.0, 3.0)));
    const double limit_m = rng.uniform(1.0, 20.0);
    caster.cast(pose, f.cosines, f.sines, limit_m, ranges);
    for (std::size_t i = 0; i < ranges.size(); ++i) {
      const double heading =
          pose.heading().radians() + 2.0 * std::numbers::pi * static_cast<double>(i) / 181.0;
      const Hit hit = traverse(m, x, y, std::cos(heading), std::sin(heading), limit_m / r);
      const double off = std::abs(static_cast<double>(ranges[i]) / r - hit.cells);
      ++rays;
      // Rounding of positions of up to 300 cells in single precision: 1e-4 of a cell.
      if (off > 5e-3) {
        ++slipped;
        EXPECT_LT(hit.corner, 5e-3) << "ray " << i << " of run " << run << " is off by " << off;
      }
    }
  }
  // About ten cells near obstacles have a corner within 5e-3 on either side.
  EXPECT_LT(slipped, rays / 100);
}

TEST(RayCaster, IsExactAlongTheGridsAxes) {
  Mask m{9, 9, std::vector<std::uint8_t>(81)};
  for (int i = 0; i < 9; ++i)
    for (const auto& [x, y] : {std::pair{0, i}, {8, i}, {i, 0}, {i, 8}})
      m.cells[static_cast<std::size_t>(9 * y + x)] = 1;
  const RayCaster caster(field_of(m, 1.0));
  const std::vector<float> c{1, 0, -1, 0}, s{0, 1, 0, -1};
  std::vector<float> ranges(4);
  caster.cast(SE2d(4.25, 4.5, Angle{}), c, s, 100.0, ranges);
  const double expected[] = {3.75, 3.5, 3.25, 3.5};
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_NEAR(static_cast<double>(ranges[i]), expected[i], 2e-3);
}

TEST(RayCaster, GivesARangeForEveryPose) {
  Mask m{5, 5, std::vector<std::uint8_t>(25)};
  m.cells[12] = 1;
  const RayCaster caster(field_of(m, 1.0));
  const std::vector<float> c{1.0F}, s{0.0F};
  std::vector<float> range(1);
  const auto cast = [&](double x, double y) {
    caster.cast(SE2d(x, y, Angle{}), c, s, 30.0, range);
    return range[0];
  };
  EXPECT_EQ(cast(2.5, 2.5), 0.0F);          // inside the obstacle
  EXPECT_EQ(cast(0.5, 0.5), 30.0F);         // leaves the map
  EXPECT_EQ(cast(-9.0, 2.5), 30.0F);        // begins outside
  EXPECT_EQ(cast(std::nan(""), 0), 30.0F);  // NaN
  EXPECT_EQ(cast(1e300, 0), 30.0F);
}

const Isa kSets[] = {Isa::avx2, Isa::avx512};

TEST(FieldKernels, EveryVariantIsBitIdentical) {
  using namespace kernels;
  const Kernels& plain = kernels_for(Isa::baseline);
  for (const Isa isa : kSets) {
    if (!runs_here(isa)) continue;
    const Kernels& fast = kernels_for(isa);
    Rng rng(6);
    for (int run = 0; run < 30; ++run) {
      const int n = 1 + static_cast<int>(rng.below(400));
      std::vector<std::uint16_t> column;
      for (int i = 0; i < n; ++i)
        column.push_back(rng.uniform() < 0.5 ? kFarCells
                                             : static_cast<std::uint16_t>(rng.below(300)));
      std::vector<std::int32_t> scratch(static_cast<std::size_t>(scratch_length(n)));
      std::vector<std::int32_t> a(static_cast<std::size_t>(n + kRowBlock)), b = a;
      ASSERT_EQ(plain.row_minimum(column.data(), n, scratch.data(), a.data()),
                fast.row_minimum(column.data(), n, scratch.data(), b.data()));
      ASSERT_EQ(a, b);

      const int w = 40, h = 30;
      std::vector<float> table(static_cast<std::size_t>((w + 2) * (h + 2)), -1.0F);
      std::vector<std::uint16_t> values(static_cast<std::size_t>((w + 2) * (h + 2)), 0);
      for (int y = 1; y <= h; ++y)
        for (int x = 1; x <= w; ++x) {
          const auto i = static_cast<std::size_t>(y * (w + 2) + x);
          table[i] = rng.uniform() < 0.02 ? 0.0F : static_cast<float>(rng.uniform(1.0, 3.0));
          values[i] = static_cast<std::uint16_t>(rng.below(4081));
        }
      std::vector<float> c, s, ra(64), rb(64), x, y;
      for (int i = 0; i < 64; ++i) {
        const double bearing = rng.uniform(-4.0, 4.0);
        c.push_back(static_cast<float>(std::cos(bearing)));
        s.push_back(static_cast<float>(std::sin(bearing)));
        x.push_back(static_cast<float>(rng.uniform(-2.0, 2.0)));
        y.push_back(static_cast<float>(rng.uniform(-2.0, 2.0)));
      }
      x[3] = 1e30F;
      y[5] = std::numeric_limits<float>::quiet_NaN();
      const RayTable rays{table.data(), w + 2, w, h};
      plain.cast(rays, 20, 15, 0.3F, 0.9F, c.data(), s.data(), 64, 50.0F, ra.data());
      fast.cast(rays, 20, 15, 0.3F, 0.9F, c.data(), s.data(), 64, 50.0F, rb.data());
      ASSERT_EQ(ra, rb);

      const Field field{values.data() + w + 3, w + 2, w, h};
      std::vector<float> ox(64, 20.0F), oy(64, 12.0F);
      for (auto& v : c) v *= 10.0F;
      for (auto& v : s) v *= 10.0F;
      std::vector<std::uint32_t> sa(64), sb(64);
      const PoseBatch poses{c.data(), s.data(), ox.data(), oy.data(), 64};
      plain.field_sums(field, x.data(), y.data(), 64, poses, sa.data());
      fast.field_sums(field, x.data(), y.data(), 64, poses, sb.data());
      ASSERT_EQ(sa, sb);
    }
  }
}

TEST(FieldKernels, SumEqualsThatOfThePointsCells) {
  Rng rng(8);
  const DistanceField distances = field_of(random_mask(rng, 60, 40, 0.02), 0.1);
  const auto grid = likelihood_field(distances);
  ASSERT_TRUE(grid);
  std::vector<float> x, y;
  for (int i = 0; i < 48; ++i) {
    x.push_back(static_cast<float>(rng.uniform(-3.0, 3.0)));
    y.push_back(static_cast<float>(rng.uniform(-3.0, 3.0)));
  }
  for (int run = 0; run < 50; ++run) {
    const SE2d pose(rng.uniform(-1.0, 7.0), rng.uniform(-1.0, 5.0),
                    Angle::radians(rng.uniform(-4.0, 4.0)));
    const auto c = static_cast<float>(pose.rotation().cos() * 10.0),
               s = static_cast<float>(pose.rotation().sin() * 10.0),
               ox = static_cast<float>(pose.x() * 10.0), oy = static_cast<float>(pose.y() * 10.0);
    std::uint32_t sum = 0;
    kernels::best_kernels().field_sums(
        {grid->data(), grid->stride(), grid->width(), grid->height()}, x.data(), y.data(), 48,
        {&c, &s, &ox, &oy, 1}, &sum);
    std::uint32_t expected = 0;
    for (std::size_t i = 0; i < 48; ++i)
      expected += static_cast<std::uint32_t>(
          grid->value({static_cast<int>(std::floor(c * x[i] - s * y[i] + ox)),
                       static_cast<int>(std::floor(s * x[i] + c * y[i] + oy))}));
    EXPECT_EQ(sum, expected);
  }
}

}  // namespace
}  // namespace wayfare
