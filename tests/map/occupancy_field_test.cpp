#include <wayfare/map/likelihood_field.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>

namespace wayfare {
namespace {

/// A grid with random cells of every log-odds.
OccupancyGrid strewn(Rng& rng) {
  OccupancyGrid grid;
  for (int i = 0; i < 4000; ++i)
    grid.update({static_cast<int>(rng.below(300)) - 150, static_cast<int>(rng.below(300)) - 150},
                LogOdds::from_nats(rng.uniform(-3, 3)));
  return grid;
}

/// The definition, one cell at a time.
double brute_force(const OccupancyGrid& grid, const Cell& c, const OccupancyFieldOptions& o) {
  double best = std::log(o.floor_probability);
  for (int y = c.y - 15; y <= c.y + 15; ++y)
    for (int x = c.x - 15; x <= c.x + 15; ++x) {
      if (!grid.observed({x, y}) || !(grid.probability({x, y}) > o.min_probability)) continue;
      const double d2 = ((x - c.x) * (x - c.x) + (y - c.y) * (y - c.y)) * 0.0025;
      best =
          std::max(best, std::log(grid.probability({x, y})) - 0.5 * d2 / (o.sigma_m * o.sigma_m));
    }
  return best;
}

// Log-odds are binned in eighths of a nat: ln p of a cell just above one half is off by 1/16 · ½.
TEST(OccupancyField, EqualsItsDefinitionWhereverPointsCanLie) {
  Rng rng(1);
  const OccupancyGrid grid = strewn(rng);
  const OccupancyFieldOptions options{0.1, 0.05, 0.5};
  const FieldReach reach{0.2, 0.1};
  PointSet points;
  for (int i = 0; i < 40; ++i)
    points.push_back(Eigen::Vector2f(static_cast<float>(rng.uniform(-4, 4)),
                                     static_cast<float>(rng.uniform(-4, 4))));
  const SE2d pose(0.5, -0.3, 0.7_rad);
  OccupancyFieldMaker maker;
  LikelihoodField view;
  for (int again = 0; again < 2; ++again) {  // with new memory, then with reused memory
    ASSERT_TRUE(maker.make(grid, points, pose, reach, options, view));
    for (std::size_t i = 0; i < points.size(); ++i)
      for (int k = 0; k < 50; ++k) {
        const SE2d moved(pose.x() + rng.uniform(-0.2, 0.2), pose.y() + rng.uniform(-0.2, 0.2),
                         pose.heading() + Angle::radians(rng.uniform(-0.1, 0.1)));
        const Cell c = cell_of(moved * Eigen::Vector2d(points[i].cast<double>()), 0.05);
        EXPECT_NEAR(view.log_likelihood(c), brute_force(grid, c, options), 0.035)
            << c.x << ' ' << c.y;
      }
  }
}

TEST(OccupancyField, ViewStaysWithinThePointsCircle) {
  Rng rng(2);
  const OccupancyGrid grid = strewn(rng);
  PointSet points;
  points.push_back({20, 0});
  LikelihoodField view;
  OccupancyFieldMaker maker;
  ASSERT_TRUE(maker.make(grid, points, SE2d(), {1.0, 3.2}, {}, view));
  EXPECT_LT(view.width(), 2 * (400 + 20 + 16 + 10));
}

TEST(OccupancyField, ReportsInvalidInput) {
  const OccupancyGrid grid;
  PointSet points;
  LikelihoodField view;
  OccupancyFieldMaker maker;
  EXPECT_FALSE(maker.make(grid, points, SE2d(), {}, {}, view));
  points.push_back({1, 1});
  EXPECT_TRUE(maker.make(grid, points, SE2d(), {}, {}, view));
  EXPECT_EQ(view.value(cell_of({1, 1}, 0.05)), 0);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(maker.make(grid, points, SE2d(nan, 0, Angle{}), {}, {}, view));
  EXPECT_TRUE(view.empty());
  EXPECT_FALSE(maker.make(grid, points, SE2d(), {}, {1.0, 0.01, 0.5}, view));
  EXPECT_FALSE(maker.make(grid, points, SE2d(), {nan, 0}, {}, view));
  points.push_back({std::numeric_limits<float>::infinity(), 0});
  EXPECT_FALSE(maker.make(grid, points, SE2d(), {}, {}, view));
}

}  // namespace
}  // namespace wayfare
