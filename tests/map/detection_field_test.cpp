#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/map/likelihood_field.hpp>

namespace wayfare {
namespace {

constexpr double kHit = 0.52;

/// Up to 60 detections per cell, on both sides of the origin and of the tiles' borders; the map is
/// slightly larger, as a view of the whole map does not blur beyond it.
OccupancyGrid strewn_detections(Rng& rng) {
  OccupancyGrid grid(detection_map());
  const double nats = LogOdds::from_probability(kHit).nats();
  for (int i = 0; i < 3000; ++i)
    grid.update({static_cast<int>(rng.below(300)) - 150, static_cast<int>(rng.below(300)) - 150},
                LogOdds::from_nats(nats * static_cast<double>(rng.below(60))));
  for (const Cell corner : {Cell{-170, -170}, Cell{170, 170}})
    grid.update(corner, LogOdds::from_nats(-0.1));
  return grid;
}

PointSet points_about(Rng& rng, double reach_m) {
  PointSet points;
  for (int i = 0; i < 40; ++i)
    points.push_back(Eigen::Vector2f(static_cast<float>(rng.uniform(-reach_m, reach_m)),
                                     static_cast<float>(rng.uniform(-reach_m, reach_m))));
  return points;
}

// The view of the whole map is blurred along x and then y, with different rounding; one step of a
// view's values is 0.002 nats.
TEST(DetectionField, EqualsTheViewOfTheWholeMapWherePointsCanLie) {
  Rng rng(1);
  const OccupancyGrid grid = strewn_detections(rng);
  const SE2d pose(0.4, -0.3, 0.7_rad);
  const FieldReach reach{0.2, 0.1};
  DetectionFieldMaker maker;
  LikelihoodField view;
  for (const double blur_m : {0.0, 0.03, 0.06}) {
    const DetectionViewOptions options{kHit, blur_m, 0.02, 30.0};
    const auto whole = detection_grid(grid, options);
    ASSERT_TRUE(whole);
    const PointSet points = points_about(rng, 3.0);
    ASSERT_TRUE(maker.make(grid, points, pose, reach, options, view));
    for (std::size_t i = 0; i < points.size(); ++i)
      for (int k = 0; k < 30; ++k) {
        const SE2d moved(pose.x() + rng.uniform(-0.2, 0.2), pose.y() + rng.uniform(-0.2, 0.2),
                         pose.heading() + Angle::radians(rng.uniform(-0.1, 0.1)));
        const Cell c = cell_of(moved * Eigen::Vector2d(points[i].cast<double>()), 0.03);
        EXPECT_NEAR(view.log_likelihood(c), whole->log_likelihood(c), 0.01) << c.x << ' ' << c.y;
      }
  }
}

// n detections in one cell, no blur: ln((n + b) / (max + b)), and 0 above the maximum.
TEST(DetectionField, EqualsTheLogarithmOfTheCount) {
  OccupancyGrid grid(detection_map());
  const LogOdds hit = LogOdds::from_probability(kHit);
  for (int i = 0; i < 12; ++i) grid.update({3, 4}, hit);
  for (int i = 0; i < 40; ++i) grid.update({5, 4}, hit);
  PointSet points;
  points.push_back(Eigen::Vector2f(0.1F, 0.1F));
  LikelihoodField view;
  ASSERT_TRUE(
      DetectionFieldMaker().make(grid, points, SE2d(), {0.5, 0.0}, {kHit, 0.0, 0.02, 30.0}, view));
  EXPECT_NEAR(view.log_likelihood({3, 4}), std::log(12.02 / 30.02), 0.002);
  EXPECT_NEAR(view.log_likelihood({4, 4}), std::log(0.02 / 30.02), 0.002);
  EXPECT_NEAR(view.log_likelihood({5, 4}), 0.0, 0.002);
}

TEST(DetectionField, ReportsInvalidInput) {
  Rng rng(2);
  const OccupancyGrid grid = strewn_detections(rng);
  const PointSet points = points_about(rng, 2.0);
  const DetectionViewOptions good{kHit, 0.03, 0.02, 30.0};
  const double nan = std::numeric_limits<double>::quiet_NaN();
  DetectionFieldMaker maker;
  LikelihoodField view;
  const auto refused = [&](const PointSet& p, const SE2d& pose, const DetectionViewOptions& o) {
    EXPECT_TRUE(maker.make(grid, points, SE2d(), {}, good, view));
    EXPECT_FALSE(maker.make(grid, p, pose, {}, o, view));
    EXPECT_TRUE(view.empty());
  };
  refused({}, SE2d(), good);
  refused(points, SE2d(nan, 0, Angle{}), good);
  refused(points, SE2d(1e9, 0, Angle{}), good);
  refused(points, SE2d(), {kHit, 0.03, 0.02, 0.0});
  refused(points, SE2d(), {kHit, 0.3, 0.02, 30.0});
  refused(points, SE2d(), {0.5, 0.03, 0.02, 30.0});
  PointSet far = points;
  far.push_back(Eigen::Vector2f(1e6F, 0));
  refused(far, SE2d(), good);
}

}  // namespace
}  // namespace wayfare
