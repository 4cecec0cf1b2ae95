#include <wayfare/map/surface_map.hpp>

#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/map/ndt_map.hpp>
#include <wayfare/map/voxel_filter.hpp>

namespace wayfare {
namespace {

PointSet strewn(Rng& rng, int n, double half) {
  PointSet points;
  for (int i = 0; i < n; ++i)
    points.push_back(
        Eigen::Vector2d(rng.uniform(-half, half), rng.uniform(-half, half)).cast<float>());
  return points;
}

TEST(VoxelFilter, GivesTheMeanOfEverySquareInOrder) {
  Rng rng(4);
  const PointSet points = strewn(rng, 3000, 2.0);
  std::map<std::pair<int, int>, std::pair<Eigen::Vector2d, int>> sums;
  std::vector<std::pair<int, int>> order;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector2d p = points[i].cast<double>();
    const std::pair square(static_cast<int>(std::floor(p.x() / 0.1)),
                           static_cast<int>(std::floor(p.y() / 0.1)));
    const auto [at, first] = sums.try_emplace(square, Eigen::Vector2d::Zero(), 0);
    if (first) order.push_back(square);
    at->second.first += p;
    ++at->second.second;
  }
  const auto filtered = voxel_filter(points, 0.1);
  ASSERT_TRUE(filtered);
  ASSERT_EQ(filtered->size(), order.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const auto& [sum, n] = sums[order[i]];
    EXPECT_LT(((*filtered)[i].cast<double>() - sum / n).norm(), 1e-6);
  }
}

TEST(VoxelFilter, ReportsPointsOutsideTheGrid) {
  PointSet nan, far;
  nan.push_back({std::numeric_limits<float>::quiet_NaN(), 0.0F});
  far.push_back({1e30F, 0.0F});
  EXPECT_FALSE(voxel_filter(nan, 0.1));
  EXPECT_FALSE(voxel_filter(far, 0.1));
  EXPECT_FALSE(voxel_filter(PointSet(), 0.0));
  EXPECT_FALSE(voxel_filter(PointSet(), std::numeric_limits<double>::quiet_NaN()));
  ASSERT_TRUE(voxel_filter(PointSet(), 0.1));
  EXPECT_TRUE(voxel_filter(PointSet(), 0.1)->empty());
}

TEST(SurfaceMap, FindsTheNearestPoint) {
  Rng rng(5);
  const PointSet points = strewn(rng, 400, 4.0);
  const PlacedPoints placed{&points, SE2d(0.3, -7, Angle::degrees(40))};
  const auto map = SurfaceMap::make({&placed, 1});
  ASSERT_TRUE(map);
  int none = 0;
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector2f p =
        Eigen::Vector2d(rng.uniform(-6, 6), rng.uniform(-13, -1)).cast<float>();
    const float reach = static_cast<float>(rng.uniform(0, 1.2));
    float best = std::numeric_limits<float>::infinity();
    for (const SurfacePoint& s : map->points()) best = std::min(best, (s.point - p).squaredNorm());
    const SurfacePoint* found = map->nearest(p, reach);
    if (best <= reach * reach) {
      ASSERT_NE(found, nullptr);
      ASSERT_EQ((found->point - p).squaredNorm(), best);
    } else {
      ASSERT_EQ(found, nullptr);
      ++none;
    }
  }
  EXPECT_GT(none, 100);
}

/// Points that move by steps of millimetres to metres: each answer is that of a search from
/// nothing.
TEST(SurfaceMapTracker, FindsWhatASearchFinds) {
  Rng rng(15);
  const PointSet points = strewn(rng, 900, 3.0);
  const PlacedPoints placed{&points, SE2d(1000.3, -7, Angle::degrees(40))};
  const auto map = SurfaceMap::make({&placed, 1});
  ASSERT_TRUE(map);
  constexpr std::size_t kCount = 101;
  std::vector<float> x(kCount), y(kCount);
  for (std::size_t i = 0; i < kCount; ++i) {
    x[i] = static_cast<float>(rng.uniform(996, 1005));
    y[i] = static_cast<float>(rng.uniform(-12, -2));
  }
  SurfaceMap::Tracker tracker(*map, kCount);
  int none = 0;
  for (int round = 0; round < 60; ++round) {
    const double step = std::pow(10.0, rng.uniform(-4, 0));
    for (std::vector<float>* axis : {&x, &y})
      for (float& v : *axis) v += static_cast<float>(rng.normal(0, step));
    const auto reach = static_cast<float>(rng.uniform(0, 1.5));
    const auto [index, squared_m2] = tracker.nearest(x, y, reach);
    for (std::size_t i = 0; i < kCount; ++i) {
      std::int32_t want = -1;
      float least = std::numeric_limits<float>::infinity();
      for (std::size_t k = 0; k < map->points().size(); ++k) {
        const Eigen::Vector2f d = map->points()[k].point - Eigen::Vector2f(x[i], y[i]);
        if (d.squaredNorm() >= least) continue;
        least = d.squaredNorm();
        want = static_cast<std::int32_t>(k);
      }
      if (least > reach * reach) want = -1;
      ASSERT_EQ(index[i], want) << round << ' ' << i;
      if (want >= 0) {
        ASSERT_EQ(squared_m2[i], least);
      }
      none += want < 0;
    }
  }
  EXPECT_GT(none, 300);
}

TEST(SurfaceMapTracker, FindsNothingFarAwayOrWithoutANumber) {
  Rng rng(16);
  const PointSet points = strewn(rng, 50, 1.0);
  const PlacedPoints placed{&points, SE2d()};
  const auto map = SurfaceMap::make({&placed, 1});
  ASSERT_TRUE(map);
  SurfaceMap::Tracker tracker(*map, 4);
  const float inf = std::numeric_limits<float>::infinity();
  const std::vector<float> x{1e30F, NAN, -inf, 0.0F}, y{0.0F, 0.0F, 0.0F, 0.0F};
  const auto index = tracker.nearest(x, y, 1.0F).index;
  EXPECT_EQ(std::vector<std::int32_t>(index.begin(), index.begin() + 3),
            std::vector<std::int32_t>(3, -1));
  EXPECT_GE(index[3], 0);
  EXPECT_EQ(tracker.nearest(x, y, NAN).index[3], -1);
}

TEST(SurfaceMap, NormalsArePerpendicularToLinesAndAbsentInClutter) {
  Rng rng(6);
  PointSet line, clutter;
  const Eigen::Vector2d along(std::cos(0.7), std::sin(0.7)), normal(-along.y(), along.x());
  for (int i = 0; i < 300; ++i)
    line.push_back(Eigen::Vector2d(0.02 * i * along + rng.normal(0, 0.003) * normal).cast<float>());
  for (int i = 0; i < 300; ++i)
    clutter.push_back(Eigen::Vector2d(20 + rng.normal(0, 0.3), rng.normal(0, 0.3)).cast<float>());
  const PlacedPoints placed[] = {{&line, SE2d()}, {&clutter, SE2d()}};
  const auto map = SurfaceMap::make(placed);
  ASSERT_TRUE(map);
  int without = 0, of_clutter = 0;
  for (const SurfacePoint& s : map->points()) {
    const Eigen::Vector2d n = s.normal.cast<double>();
    if (s.point.x() > 10.0F) {
      ++of_clutter;
      without += n.isZero(0);
      continue;
    }
    ASSERT_NEAR(n.norm(), 1, 1e-5);
    ASSERT_GT(std::abs(n.dot(normal)), std::cos(0.1));
  }
  EXPECT_GT(without, of_clutter / 2);
}

TEST(NdtMap, HasMeanAndCovarianceOfEverySquare) {
  Rng rng(7);
  const PointSet points = strewn(rng, 4000, 1.9);
  const PlacedPoints placed{&points, SE2d()};
  const auto map = NdtMap::make({&placed, 1}, {{1.0}, 5, 0.03});
  ASSERT_TRUE(map);
  for (int t = 0; t < NdtMap::Level::kTilings; ++t) {
    const Eigen::Vector2d shift = 0.5 * Eigen::Vector2d(t & 1, t >> 1);
    const Eigen::Vector2d place(0.3, -0.8);
    const NdtCell* cell = map->levels()[0].at(place, t);
    ASSERT_NE(cell, nullptr);
    const auto square = [&](const Eigen::Vector2d& p) {
      return Eigen::Vector2d((p + shift).array().floor());
    };
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();
    double n = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector2d p = points[i].cast<double>();
      if (square(p) != square(place)) continue;
      sum += p;
      squares += p * p.transpose();
      n += 1;
    }
    const Eigen::Matrix2d covariance = squares / n - sum * sum.transpose() / (n * n);
    EXPECT_LT((cell->mean - sum / n).norm(), 1e-9);
    EXPECT_LT((cell->information * covariance - Eigen::Matrix2d::Identity()).norm(), 1e-6);
  }
  EXPECT_EQ(map->levels()[0].at({300, 0}, 0), nullptr);
}

/// By the definition, in double precision, far from the map's origin too.
TEST(NdtMap, SumsAreThoseOfTheDistributionsAtThePoints) {
  Rng rng(8);
  for (const double away : {0.0, 900.0}) {
    const PointSet points = strewn(rng, 3000, 4.0), seen = strewn(rng, 333, 5.0);
    const PlacedPoints placed{&points, SE2d(away, -away, Angle::degrees(20))};
    const auto map = NdtMap::make({&placed, 1}, {{0.7}, 5, 0.1});
    ASSERT_TRUE(map);
    const NdtMap::Level& level = map->levels()[0];
    for (int i = 0; i < 20; ++i) {
      const SE2d pose(away + rng.normal(0, 0.3), -away + rng.normal(0, 0.3),
                      Angle::radians(rng.uniform(-3, 3)));
      NdtMap::Sums want;
      for (std::size_t k = 0; k < seen.size(); ++k) {
        const Eigen::Vector2d rotated = pose.rotation() * Eigen::Vector2d(seen[k].cast<double>());
        const Eigen::Vector2d p = rotated + pose.translation();
        Eigen::Matrix<double, 2, 3> jacobian;
        jacobian << 1, 0, -rotated.y(), 0, 1, rotated.x();
        for (int t = 0; t < NdtMap::Level::kTilings; ++t) {
          const NdtCell* cell = level.at(p, t);
          if (cell == nullptr) continue;
          const Eigen::Vector2d d = p - cell->mean;
          const double e = std::exp(-0.5 * d.dot(cell->information * d));
          want.likelihood += e;
          want.pull += e * jacobian.transpose() * cell->information * d;
          want.hessian += e * jacobian.transpose() * cell->information * jacobian;
        }
      }
      const NdtMap::Sums got = level.sums(seen, pose);
      // Single precision on some 1000 terms; points of the map are rounded to floats.
      const double tolerance = away > 0 ? 2e-3 : 2e-5;
      EXPECT_NEAR(got.likelihood, want.likelihood, tolerance * want.likelihood);
      EXPECT_LT((got.pull - want.pull).norm(), tolerance * want.hessian.norm());
      EXPECT_LT((got.hessian - want.hessian).norm(), tolerance * want.hessian.norm());
    }
  }
}

TEST(SurfaceAndNdtMaps, ReportInvalidInput) {
  PointSet nan, far, good;
  nan.push_back({std::numeric_limits<float>::quiet_NaN(), 0.0F});
  good.push_back({1.0F, 1.0F});
  far.push_back({-9e6F, -9e6F});
  far.push_back({9e6F, 9e6F});
  const auto refused = [](const PointSet& p, const SE2d& pose) {
    const PlacedPoints placed{&p, pose};
    return !SurfaceMap::make({&placed, 1}) && !NdtMap::make({&placed, 1});
  };
  EXPECT_TRUE(refused(nan, SE2d()));
  EXPECT_TRUE(refused(PointSet(), SE2d()));
  EXPECT_TRUE(refused(good, SE2d(std::numeric_limits<double>::infinity(), 0, Angle())));
  EXPECT_TRUE(refused(far, SE2d()));
  EXPECT_FALSE(refused(good, SE2d()));
  const PlacedPoints placed{&good, SE2d()};
  EXPECT_FALSE(SurfaceMap::make({&placed, 1}, {.normal_radius_m = 0}));
  EXPECT_FALSE(NdtMap::make({&placed, 1}, {{}, 5, 0.03}));
  EXPECT_FALSE(NdtMap::make({&placed, 1}, {{-1.0}, 5, 0.03}));
}

}  // namespace
}  // namespace wayfare
