#include <cmath>

#include <gtest/gtest.h>

#include <wayfare/match/refine.hpp>

#include "scenes.hpp"

namespace wayfare {
namespace {

TEST(LikelihoodField, IsTheNearestPointsGaussian) {
  Rng rng(2);
  const PointSet points = rectangle(1.5, 1.0, 60, rng);
  const SE2d pose(-37.3, 12.9, Angle::degrees(77));
  const PlacedPoints placed{&points, pose};
  const auto field = likelihood_field({&placed, 1}, {0.05, 0.1, 0.01});
  ASSERT_TRUE(field);
  for (int y = field->origin().y - 3; y < field->origin().y + field->height() + 3; ++y)
    for (int x = field->origin().x - 3; x < field->origin().x + field->width() + 3; ++x) {
      double want = std::log(0.01);
      for (std::size_t i = 0; i < points.size(); ++i) {
        // Places are rounded to the middles of quarter cells.
        Eigen::Vector2d q = pose * Eigen::Vector2d(points[i].cast<double>());
        q = ((q / 0.0125).array().floor() + 0.5) * 0.0125;
        want = std::max(want, -(centre_of({x, y}, 0.05) - q).squaredNorm() / (2 * 0.1 * 0.1));
      }
      ASSERT_NEAR(field->log_likelihood({x, y}), want, 0.6 * field->log_step()) << x << ' ' << y;
    }
}

TEST(LikelihoodField, RefusesWhatItCannotHold) {
  LikelihoodFieldMaker maker;
  MatchGrid grid;
  PointSet far, nan, good;
  far.push_back({0.0F, 0.0F});
  far.push_back({12000.0F, 12000.0F});
  nan.push_back({NAN, 1.0F});
  good.push_back({1.0F, 1.0F});
  const auto refused = [&](const PointSet& p, const SE2d& pose, LikelihoodFieldOptions o = {}) {
    const PlacedPoints placed{&p, pose};
    return !maker.make({&placed, 1}, o, grid) && grid.empty();
  };
  EXPECT_TRUE(refused(far, SE2d()));
  EXPECT_TRUE(refused(nan, SE2d()));
  EXPECT_TRUE(refused(PointSet(), SE2d()));
  EXPECT_TRUE(refused(good, SE2d(INFINITY, 0, Angle())));
  EXPECT_TRUE(refused(good, SE2d(), {0.01, 1.0, 0.01}));
  EXPECT_FALSE(refused(good, SE2d()));
}

TEST(MatchGridOfOccupancy, GivesTheLogOfTheProbability) {
  OccupancyGrid map;
  map.update({-70, 3}, LogOdds::from_probability(0.9));
  map.update({5, 4}, LogOdds::from_probability(0.2));
  const auto view = match_grid(map, {0.05, 0.0, 0.3});
  ASSERT_TRUE(view);
  EXPECT_NEAR(view->log_likelihood({-70, 3}), std::log(0.9), 1e-3);
  EXPECT_NEAR(view->log_likelihood({5, 4}), std::log(0.2), 1e-3);
  EXPECT_NEAR(view->log_likelihood({0, 3}), std::log(0.3), 1e-3);
  EXPECT_NEAR(view->log_likelihood({6, 4}), std::log(0.05), 1e-9);
  EXPECT_FALSE(match_grid(OccupancyGrid()));
}

TEST(Interpolate, GradientIsTheDerivative) {
  Rng rng(4);
  const MatchGrid grid = random_grid(rng, 23, 17, {-9, 4});
  for (int i = 0; i < 2000; ++i) {
    // Within a patch between four centres, the table's border included.
    const double u = static_cast<int>(rng.below(24)) - 1 + rng.uniform(0.01, 0.99);
    const double v = static_cast<int>(rng.below(18)) - 1 + rng.uniform(0.01, 0.99);
    const Eigen::Vector2d p = 0.05 * Eigen::Vector2d(u + 0.5 - 9, v + 0.5 + 4);
    const auto value = [&](double x, double y) {
      return interpolate(grid, p + Eigen::Vector2d(x, y)).log_likelihood;
    };
    const Eigen::Vector2d numeric((value(1e-5, 0) - value(-1e-5, 0)) / 2e-5,
                                  (value(0, 1e-5) - value(0, -1e-5)) / 2e-5);
    ASSERT_LT((numeric - interpolate(grid, p).gradient).norm(), 1e-5 * (1 + numeric.norm()));
  }
  EXPECT_EQ(interpolate(grid, {1e30, NAN}).log_likelihood, grid.log_floor());
}

TEST(Refine, FindsAKnownMotionBetweenCellsAndIsNeverWorse) {
  Rng rng(9);
  const PointSet room = rectangle(4, 3, 2000, rng, 0.005), scan = rectangle(4, 3, 360, rng, 0.005);
  const PlacedPoints placed{&room, SE2d()};
  const auto field = likelihood_field({&placed, 1});
  double squares = 0;
  for (int i = 0; i < 50; ++i) {
    const SE2d truth(rng.uniform(-0.5, 0.5), rng.uniform(-0.5, 0.5),
                     Angle::radians(rng.uniform(-1, 1)));
    const PointSet seen = moved(scan, truth.inverse());
    const SE2d start =
        truth.plus({rng.uniform(-0.04, 0.04), rng.uniform(-0.04, 0.04), rng.uniform(-0.01, 0.01)});
    const auto before = refine(*field, seen, start, {0, 1e-4, 0.2});
    const auto after = refine(*field, seen, start);
    ASSERT_TRUE(before && after);
    EXPECT_GE(after->score, before->score);
    const Eigen::Vector3d error = after->T_map_points.minus(truth);
    squares += error.head<2>().squaredNorm();
    EXPECT_LT(std::abs(error[2]), 0.008);
  }
  // The starts are 0.033 m off (uniform, √(2·0.08²/12)); the field's own places are rounded to
  // quarter cells of 0.0125 m.
  EXPECT_LT(std::sqrt(squares / 50), 0.0125);
}

}  // namespace
}  // namespace wayfare
