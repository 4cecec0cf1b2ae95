#include <wayfare/match/scan_matcher.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

#include <wayfare/match/correlative.hpp>

#include "reference.hpp"
#include "scenes.hpp"

namespace wayfare {
namespace {

static_assert(ScanMatcher<CorrelativeMatcher> && ScanMatcher<BranchAndBoundMatcher>);

TEST(Matchers, EqualBruteForceOnRandomScenes) {
  Rng rng(7);
  CorrelativeMatcher correlative;
  BranchAndBoundMatcher branch_and_bound;
  int none = 0;
  for (int scene = 0; scene < 300; ++scene) {
    SCOPED_TRACE(scene);
    const Cell origin{static_cast<int>(rng.below(200)) - 100,
                      static_cast<int>(rng.below(200)) - 100};
    const LikelihoodField grid = random_grid(rng, 1 + static_cast<int>(rng.below(70)),
                                             1 + static_cast<int>(rng.below(70)), origin);
    PointSet points;  // many fall outside the table, some far outside
    const double reach = rng.uniform(0.1, 3);
    for (std::uint64_t n = 1 + rng.below(40); n > 0; --n)
      points.push_back(
          Eigen::Vector2d(rng.uniform(-reach, reach), rng.uniform(-reach, reach)).cast<float>());
    if (scene % 5 == 0) points.push_back({1e9F, -4.0F});
    const SE2d prior(0.05 * (origin.x + 20) + rng.uniform(-1, 1),
                     0.05 * (origin.y + 20) + rng.uniform(-1, 1),
                     Angle::radians(rng.uniform(-4, 4)));
    // Of 1 to 181 columns.
    const double widest = scene % 10 == 1 ? 3.0 : scene % 10 == 6 ? 4.5 : 0.9;
    const SearchWindow window{rng.uniform(0, widest), rng.uniform(0, 0.9),
                              Angle::radians(scene % 5 == 0 ? 1e-9 : rng.uniform(0, 0.1))};
    MatchOptions options;
    if (scene % 3 == 1) options.min_score = rng.uniform(0.1, 0.5);
    if (scene % 3 == 2) {
      const Eigen::Matrix3d a = Eigen::Matrix3d::NullaryExpr([&] { return rng.normal(0, 3); });
      options.prior_information = a * a.transpose();
      options.independent_points = 10;
    }
    const auto shape = correlative.surface(grid, points, prior, window, options);
    ASSERT_TRUE(shape) << shape.error().to_string();
    const Reference want = brute_force(grid, points, prior, *shape, options);
    none += !want.found;
    const double n = static_cast<double>(points.size());
    if (want.found) {
      // The surface contains the floor of the points that count as independent.
      const double independent = options.independent_points > 0 ? options.independent_points : n;
      EXPECT_NEAR(shape->at(want.candidate),
                  want.objective + std::min(n, independent) * grid.log_floor(),
                  1e-9 * (1.0 + std::abs(want.objective)));
    }
    for (const auto& got :
         {correlative.match(grid, points, prior, window, options),
          branch_and_bound.match(PrecomputationGrids(grid), points, prior, window, options)}) {
      ASSERT_TRUE(got) << got.error().to_string();
      ASSERT_EQ(got->has_value(), want.found);
      if (!want.found) continue;
      EXPECT_EQ((*got)->candidate.offset, want.candidate.offset);
      EXPECT_EQ((*got)->candidate.heading_step, want.candidate.heading_step);
      EXPECT_DOUBLE_EQ((*got)->score,
                       static_cast<double>(want.sum) / static_cast<double>(points.size()) / 4080);
      EXPECT_NEAR((*got)->mean_log_likelihood,
                  grid.log_floor() + grid.log_step() * static_cast<double>(want.sum) / n, 1e-12);
    }
  }
  EXPECT_GT(none, 5);  // rejections were among the cases
}

TEST(Matchers, AgreeOnAWholeMapAtAllHeadings) {
  Rng rng(3);
  const PointSet room = rectangle(6.0, 2.5, 600, rng);
  const PlacedPoints placed{&room, SE2d()};
  const auto field = likelihood_field({&placed, 1});
  ASSERT_TRUE(field);
  const SE2d truth(1.2, -0.7, Angle::degrees(140));
  const PointSet seen = moved(room, truth.inverse());
  const SearchWindow window{3.0, 3.0, Angle::degrees(180)};
  CorrelativeMatcher correlative;
  BranchAndBoundMatcher branch_and_bound;
  const auto a = correlative.match(*field, seen, SE2d(), window);
  const auto b = branch_and_bound.match(PrecomputationGrids(*field), seen, SE2d(), window);
  ASSERT_TRUE(a && *a && b && *b);
  EXPECT_EQ((*a)->candidate, (*b)->candidate);
  EXPECT_EQ((*a)->score, (*b)->score);
  EXPECT_GT((*a)->score, 0.9);
}

TEST(Matchers, BreakTiesByDistanceToThePriorThenInOrder) {
  LikelihoodField grid;
  ASSERT_TRUE(grid.reset(0.05, {{-20, -20}, {20, 20}}, 0.01));
  PointSet one;
  one.push_back({0.025F, 0.025F});
  const SearchWindow window{0.5, 0.5, Angle::degrees(90)}, still{0.5, 0.5, Angle()};
  CorrelativeMatcher correlative;
  BranchAndBoundMatcher bounded;
  EXPECT_EQ((**correlative.match(grid, one, SE2d(), window)).candidate, Candidate{});
  EXPECT_EQ((**bounded.match(PrecomputationGrids(grid), one, SE2d(), window)).candidate,
            Candidate{});
  for (const Cell c : {Cell{3, 0}, Cell{-3, 0}, Cell{0, 3}, Cell{0, -3}})
    grid.data()[(c.y + 20) * grid.stride() + c.x + 20] = 1000;
  const Candidate want{{0, -3}, 0};  // equally near: the lowest row
  EXPECT_EQ((**correlative.match(grid, one, SE2d(), still)).candidate, want);
  EXPECT_EQ((**bounded.match(PrecomputationGrids(grid), one, SE2d(), still)).candidate, want);
}

double uniform_variance(double width) { return width * width / 12.0; }

// In a map of one value all candidates are equal: the distribution is uniform over the window with
// its outer cells, (2n + 1) r wide, along the map's axes. A point at 1 m moves by a cell of 5 cm at
// 2 asin(0.025) = 0.050005 rad: ±10° are 4 steps of 2.5° to either side; ±0.31 m and ±0.2 m are 7
// and 4 cells.
TEST(Correlative, CovarianceOfAFlatMapIsThatOfTheWindow) {
  constexpr std::uint16_t kHalf = LikelihoodField::kMaxValue / 2;
  constexpr double kFloor = 0.5;
  LikelihoodField flat;
  ASSERT_TRUE(flat.reset(0.05, {{-200, -200}, {199, 199}}, kFloor));
  for (int y = 0; y < 400; ++y) std::fill_n(flat.data() + y * flat.stride(), 400, kHalf);
  const double log_p = 0.5 * std::log(kFloor);
  PointSet one;
  one.push_back({0.0F, 1.0F});
  const SE2d prior(0.3, -0.2, Angle::degrees(30));
  const SearchWindow window{0.31, 0.2, Angle::degrees(10)};
  CorrelativeMatcher matcher;
  const auto shape = matcher.surface(flat, one, prior, window);
  ASSERT_TRUE(shape);
  EXPECT_EQ(shape->half_x, 7);
  EXPECT_EQ(shape->half_y, 4);
  EXPECT_EQ(shape->half_heading, 4);
  EXPECT_EQ(shape->resolution_m, 0.05);
  EXPECT_NEAR(shape->heading_step.degrees(), 2.5, 1e-12);
  EXPECT_NEAR(shape->at({{7, -4}, 4}), log_p, 1e-9);
  const auto match = matcher.match(flat, one, prior, window, {.covariance = true});
  ASSERT_TRUE(match && *match && (*match)->covariance);
  EXPECT_EQ((*match)->candidates, 15 * 9 * 9);
  EXPECT_NEAR((*match)->mean_log_likelihood, log_p, 1e-9);
  EXPECT_NEAR((*match)->score, 0.5, 1e-12);
  const double turn_step = Angle::degrees(2.5).radians();
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  rotation.topLeftCorner<2, 2>() = prior.rotation().matrix();
  const Eigen::Matrix3d along_map =
      Eigen::Vector3d(uniform_variance(15 * 0.05), uniform_variance(9 * 0.05),
                      uniform_variance(9 * turn_step))
          .asDiagonal();
  EXPECT_LT((*(*match)->covariance - rotation.transpose() * along_map * rotation).norm(), 1e-9);
  // A prior of 0.1 m, 0.15 m and 0.04 rad in its own axes, far inside the window, is the
  // distribution; a cell and a heading step add their own variance.
  MatchOptions options{.covariance = true};
  options.prior_information = Eigen::Vector3d(100.0, 1.0 / 0.0225, 625.0).asDiagonal();
  const auto held = matcher.match(flat, one, prior, {0.8, 0.8, Angle::degrees(10)}, options);
  ASSERT_TRUE(held && *held && (*held)->covariance);
  const Eigen::Matrix3d posterior =
      Eigen::Vector3d(0.01 + uniform_variance(0.05), 0.0225 + uniform_variance(0.05),
                      0.0016 + uniform_variance(turn_step))
          .asDiagonal();
  EXPECT_LT((*(*held)->covariance - posterior).norm(), 1e-6);
}

// Of ±8 cells and ±8 heading steps about the match, whatever the window: 17 of each.
TEST(BranchAndBound, CovarianceOfAFlatMapIsThatOfEightSteps) {
  LikelihoodField flat;
  ASSERT_TRUE(flat.reset(0.05, {{-20, -20}, {20, 20}}, 0.5));
  PointSet one;
  one.push_back({0.0F, 1.0F});
  const double step = 2.0 * std::asin(0.025);
  const auto match =
      BranchAndBoundMatcher().match(PrecomputationGrids(flat), one, SE2d(),
                                    {0.3, 0.1, Angle::radians(4 * step)}, {.covariance = true});
  ASSERT_TRUE(match && *match && (*match)->covariance);
  EXPECT_EQ((*match)->candidates, 13 * 5 * 9);
  const Eigen::Matrix3d want =
      Eigen::Vector3d(uniform_variance(17 * 0.05), uniform_variance(17 * 0.05),
                      uniform_variance(17 * step))
          .asDiagonal();
  EXPECT_LT((*(*match)->covariance - want).norm(), 1e-6);
}

TEST(Correlative, CovarianceIsWideAlongACorridor) {
  Rng rng(11);
  const SO2d along(Angle::degrees(30));
  PointSet walls, seen;  // the walls extend beyond the visible part
  for (int i = 0; i < 900; ++i) {
    walls.push_back(
        (along * Eigen::Vector2d(rng.uniform(-8, 8), i % 2 == 0 ? 1.0 : -1.0)).cast<float>());
    if (i % 2 == 0 && walls[walls.size() - 1].norm() < 5) seen.push_back(walls[walls.size() - 1]);
  }
  const PlacedPoints placed{&walls, SE2d()};
  const auto field = likelihood_field({&placed, 1});
  CorrelativeMatcher matcher;
  MatchOptions options;
  options.independent_points = 40;
  options.covariance = true;
  const auto m = matcher.match(*field, seen, SE2d(0, 0, Angle::degrees(5)),
                               {0.5, 0.5, Angle::degrees(10)}, options);
  ASSERT_TRUE(m && *m && (*m)->covariance);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(
      Eigen::Matrix2d((*m)->covariance->topLeftCorner<2, 2>()));
  EXPECT_GT(eigen.eigenvalues()[1], 10 * eigen.eigenvalues()[0]);
  const Eigen::Vector2d ridge =
      (*m)->T_map_points.rotation() * Eigen::Vector2d(eigen.eigenvectors().col(1));
  EXPECT_GT(std::abs(ridge.dot(along * Eigen::Vector2d(1, 0))), std::cos(0.1));
}

TEST(Matchers, ReportInvalidInput) {
  LikelihoodField grid;
  ASSERT_TRUE(grid.reset(0.05, {{0, 0}, {99, 99}}, 0.01));
  const PrecomputationGrids grids(grid);
  CorrelativeMatcher correlative;
  BranchAndBoundMatcher bounded;
  PointSet good;
  good.push_back({1.0F, 2.0F});
  PointSet bad = good;
  bad.push_back({NAN, 0.0F});
  const auto refused = [&](const PointSet& p, const SE2d& prior, const SearchWindow& w,
                           const MatchOptions& o = {}) {
    return !correlative.match(grid, p, prior, w, o) && !bounded.match(grids, p, prior, w, o);
  };
  EXPECT_FALSE(refused(good, SE2d(), {}));
  EXPECT_TRUE(refused(PointSet(), SE2d(), {}));
  EXPECT_TRUE(refused(bad, SE2d(), {}));
  EXPECT_TRUE(refused(good, SE2d(NAN, 0, Angle()), {}));
  EXPECT_TRUE(refused(good, SE2d(), {-1, 0, Angle()}));
  EXPECT_TRUE(refused(good, SE2d(), {NAN, 0, Angle()}));
  EXPECT_TRUE(refused(good, SE2d(), {1e7, 1e7, Angle::degrees(180)}));
  MatchOptions indefinite;
  indefinite.prior_information = Eigen::Vector3d(1, -1, 1).asDiagonal();
  EXPECT_TRUE(refused(good, SE2d(), {}, indefinite));
  EXPECT_FALSE(correlative.match(LikelihoodField(), good, SE2d(), {}));
}

}  // namespace
}  // namespace wayfare
