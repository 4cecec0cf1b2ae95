// Properties of every matcher, on walls of exactly known geometry.

#include <cmath>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/LU>

#include <wayfare/map/inverse_lidar.hpp>
#include <wayfare/match/correlative.hpp>
#include <wayfare/match/detail/scene_constraint.hpp>
#include <wayfare/match/gauss_newton.hpp>
#include <wayfare/match/registration.hpp>
#include <wayfare/testing/matcher_laws.hpp>

#include "walls.hpp"

namespace wayfare {
namespace {

struct Views {
  std::vector<LaserScan> scans;
  std::vector<PointSet> points;
  std::vector<PlacedPoints> placed;

  Views(const Walls& walls, const std::vector<SE2d>& poses, Rng& rng) {
    for (const SE2d& pose : poses) {
      scans.push_back(walls.scan(pose, rng));
      points.push_back(end_points(scans.back()));
    }
    for (std::size_t i = 0; i < poses.size(); ++i) placed.push_back({&points[i], poses[i]});
  }
};

/// How each matcher's map is built from the same views, and its accuracy.
template <class M>
struct Setup;

template <>
struct Setup<CorrelativeMatcher> {
  static constexpr double kNear_m = 0.05, kNear_deg = 0.6;
  static CorrelativeMatcher matcher() { return {}; }
  static LikelihoodField map(const Views& v) { return *map_of(v.placed); }
  static Result<LikelihoodField> map_of(std::span<const PlacedPoints> scans) {
    return likelihood_field(scans, {0.05, 0.05, 0.01});
  }
};
template <>
struct Setup<BranchAndBoundMatcher> {
  static constexpr double kNear_m = 0.05, kNear_deg = 0.6;
  static BranchAndBoundMatcher matcher() { return {}; }
  static PrecomputationGrids map(const Views& v) { return *map_of(v.placed); }
  static Result<PrecomputationGrids> map_of(std::span<const PlacedPoints> scans) {
    return PrecomputationGrids(*Setup<CorrelativeMatcher>::map_of(scans));
  }
};
template <Interpolation kInterpolation>
struct GaussNewton : GaussNewtonMatcher {
  GaussNewton() : GaussNewtonMatcher({.interpolation = kInterpolation, .max_iterations = 20}) {}
};
template <Interpolation kInterpolation>
struct Setup<GaussNewton<kInterpolation>> {
  static constexpr double kNear_m = 0.03, kNear_deg = 0.4;
  static GaussNewton<kInterpolation> matcher() { return {}; }
  static ProbabilityPyramid map(const Views& v) {
    return pyramid([&](OccupancyGrid& grid, ScanRaster& raster) {
      for (std::size_t i = 0; i < v.scans.size(); ++i)
        (void)insert_scan(grid, v.placed[i].T_map_points, v.scans[i], {}, raster);
    });
  }
  static Result<ProbabilityPyramid> map_of(std::span<const PlacedPoints> scans) {
    return pyramid([&](OccupancyGrid& grid, ScanRaster& raster) {
      for (const PlacedPoints& scan : scans)
        (void)insert_points(grid, scan.T_map_points, *scan.points, {}, raster);
    });
  }

 private:
  template <class Insert>
  static ProbabilityPyramid pyramid(const Insert& insert) {
    ProbabilityPyramid tables;
    for (const double cell : {0.2, 0.1, 0.05}) {
      OccupancyGrid grid({.resolution_m = cell});
      ScanRaster raster;
      insert(grid, raster);
      (void)tables.emplace_back().make(grid, 0.1);
    }
    return tables;
  }
};
template <>
struct Setup<IcpMatcher> {
  static constexpr double kNear_m = 0.01, kNear_deg = 0.2;
  static IcpMatcher matcher() { return IcpMatcher(); }
  static SurfaceMap map(const Views& v) { return *map_of(v.placed); }
  static Result<SurfaceMap> map_of(std::span<const PlacedPoints> scans) {
    return matcher().make_map(scans);
  }
};
template <>
struct Setup<NdtMatcher> {
  static constexpr double kNear_m = 0.02, kNear_deg = 0.3;
  static NdtMatcher matcher() { return NdtMatcher(); }
  static NdtMap map(const Views& v) { return *map_of(v.placed); }
  static Result<NdtMap> map_of(std::span<const PlacedPoints> scans) {
    return matcher().make_map(scans);
  }
};

template <class M>
class EveryMatcher : public ::testing::Test {};
using All = ::testing::Types<CorrelativeMatcher, BranchAndBoundMatcher,
                             GaussNewton<Interpolation::bilinear>,
                             GaussNewton<Interpolation::bicubic>, IcpMatcher, NdtMatcher>;
TYPED_TEST_SUITE(EveryMatcher, All);

const SearchWindow kWindow{0.5, 0.5, Angle::degrees(20)};

std::vector<SE2d> places_in_the_room(Rng& rng) {
  std::vector<SE2d> poses;
  for (int i = 0; i < 12; ++i)
    poses.emplace_back(rng.uniform(-2.5, 2), rng.uniform(-1.5, 1.5),
                       Angle::radians(rng.uniform(-3, 3)));
  return poses;
}

/// In the middle of a corridor in the given direction.
std::vector<SE2d> places_along(Angle heading) {
  const SO2d rotation(heading);
  std::vector<SE2d> along;
  for (int i = -4; i <= 4; ++i)
    along.emplace_back(Eigen::Vector2d(rotation * Eigen::Vector2d(0.37 * i, 0)), SO2d());
  return along;
}

TYPED_TEST(EveryMatcher, FindsAKnownMotion) {
  using Case = Setup<TypeParam>;
  Rng rng(31);
  const Walls room = Walls::room();
  const auto map = Case::map(Views(room, places_in_the_room(rng), rng));
  auto matcher = Case::matcher();
  for (int i = 0; i < 20; ++i) {
    SCOPED_TRACE(i);
    const SE2d truth(rng.uniform(-2, 1.5), rng.uniform(-1, 1), Angle::radians(rng.uniform(-3, 3)));
    const PointSet seen = end_points(room.scan(truth, rng));
    const SE2d prior =
        truth.plus({rng.uniform(-0.1, 0.1), rng.uniform(-0.1, 0.1), rng.uniform(-0.07, 0.07)});
    const auto match = matcher.match(map, seen, prior, kWindow, {.min_score = 0.3});
    ASSERT_TRUE(match) << match.error().to_string();
    ASSERT_TRUE(match->has_value());
    const Eigen::Vector3d off = (*match)->T_map_points.minus(truth);
    EXPECT_LT(off.head<2>().norm(), Case::kNear_m);
    EXPECT_LT(std::abs(off[2]), Case::kNear_deg * std::numbers::pi / 180);
    EXPECT_GT((*match)->score, 0.5);
    EXPECT_LE((*match)->score, 1.0);
  }
}

TYPED_TEST(EveryMatcher, ReportsTheUnconstrainedDirection) {
  using Case = Setup<TypeParam>;
  Rng rng(32);
  auto matcher = Case::matcher();
  const auto constraint = [&](const Walls& walls, const std::vector<SE2d>& poses) {
    const auto map = Case::map(Views(walls, poses, rng));
    const auto match = matcher.match(map, end_points(walls.scan(SE2d(), rng)), SE2d(), kWindow,
                                     {.covariance = true});
    EXPECT_TRUE(match && *match && (*match)->constraint);
    return (*match)->constraint.value_or(SceneConstraint{});
  };
  const SceneConstraint room = constraint(Walls::room(), places_in_the_room(rng));
  EXPECT_TRUE(room.complete());
  EXPECT_GT(room.share, 0.05);
  for (const double degrees : {0.0, 33.0}) {
    const Angle heading = Angle::degrees(degrees);
    const SO2d rotation(heading);
    const SceneConstraint c = constraint(Walls::corridor(heading), places_along(heading));
    EXPECT_FALSE(c.complete());
    EXPECT_LT(c.share, 0.01);
    EXPECT_GT(std::abs(c.weakest.head<2>().dot(rotation * Eigen::Vector2d(1, 0))), 0.95)
        << c.weakest.transpose();
  }
  const SceneConstraint c = constraint(Walls::round_room(3), {SE2d()});
  EXPECT_FALSE(c.complete()) << c.share;
  EXPECT_GT(std::abs(c.weakest[2]), 0.95) << c.weakest.transpose();
}

TYPED_TEST(EveryMatcher, CovarianceIsWideAlongTheUnconstrainedDirection) {
  using Case = Setup<TypeParam>;
  Rng rng(33);
  auto matcher = Case::matcher();
  const Walls corridor = Walls::corridor(Angle());
  const auto map = Case::map(Views(corridor, places_along(Angle()), rng));
  const auto match = matcher.match(map, end_points(corridor.scan(SE2d(), rng)), SE2d(), kWindow,
                                   {.independent_points = 40, .covariance = true});
  ASSERT_TRUE(match && *match && (*match)->covariance);
  const Eigen::Matrix3d& c = *(*match)->covariance;
  EXPECT_TRUE(c.isApprox(c.transpose()));
  EXPECT_GT(c(0, 0), 9 * c(1, 1));
  EXPECT_LE(c(0, 0), 0.5 * 0.5 * 1.001) << "wider than the window";
}

TYPED_TEST(EveryMatcher, StaysAtItsPriorAlongTheUnconstrainedDirection) {
  using Case = Setup<TypeParam>;
  Rng rng(34);
  auto matcher = Case::matcher();
  const Walls corridor = Walls::corridor(Angle());
  const auto map = Case::map(Views(corridor, places_along(Angle()), rng));
  MatchOptions options;
  options.independent_points = 40;
  options.prior_information = Eigen::Vector3d(1e5, 1.0, 1.0).asDiagonal();
  const SE2d prior(0.4, 0.08, Angle::degrees(3));
  const auto match = matcher.match(map, end_points(corridor.scan(SE2d(0.4, 0, Angle()), rng)),
                                   prior, kWindow, options);
  ASSERT_TRUE(match && *match);
  const Eigen::Vector3d moved = (*match)->T_map_points.minus(prior);
  // The prior's position information is that of 3 mm; its x axis is 3° off the corridor's.
  EXPECT_NEAR(moved[0], 0, 0.02);
  EXPECT_NEAR((*match)->T_map_points.y(), 0, Case::kNear_m);
  EXPECT_NEAR((*match)->T_map_points.heading().degrees(), 0, Case::kNear_deg);
}

TYPED_TEST(EveryMatcher, SatisfiesTheLaws) {
  using Case = Setup<TypeParam>;
  testing::MatcherLaws<TypeParam> laws;
  laws.map_of = [](std::span<const PlacedPoints> scans) { return Case::map_of(scans); };
  laws.near_m = Case::kNear_m;
  laws.near_turn = Angle::degrees(Case::kNear_deg);
  laws.check();
}

// 40° off, points at 3.5 m are 2.4 m from their walls, beyond what a table of 0.2 m attracts: of
// the starts 10° apart only the farther ones on the right side lead to the truth.
TEST(GaussNewtonMatcher, StartsRotatedWithinTheWindowReachFarHeadings) {
  using Case = wayfare::Setup<GaussNewton<Interpolation::bilinear>>;
  Rng rng(38);
  const Walls room = Walls::room();
  const auto map = Case::map(Views(room, places_in_the_room(rng), rng));
  const SearchWindow window{0.5, 0.5, Angle::degrees(41)};
  GaussNewtonOptions options{.max_iterations = 20};
  for (const double degrees : {-40.0, 40.0}) {
    SCOPED_TRACE(degrees);
    const SE2d truth(-0.5, 0.4, Angle::degrees(20));
    const PointSet seen = end_points(room.scan(truth, rng));
    const SE2d prior(-0.55, 0.42, Angle::degrees(20 + degrees));
    const auto is_found = [&](double step_deg) {
      options.start_step = Angle::degrees(step_deg);
      const auto match = GaussNewtonMatcher(options).match(map, seen, prior, window);
      EXPECT_TRUE(match);
      if (!match || !*match) return false;
      const Eigen::Vector3d off = (*match)->T_map_points.minus(truth);
      return off.head<2>().norm() < Case::kNear_m &&
             std::abs(off[2]) < Case::kNear_deg * std::numbers::pi / 180;
    };
    EXPECT_TRUE(is_found(10.0));
    EXPECT_FALSE(is_found(0.0));   // from the prior only
    EXPECT_FALSE(is_found(42.0));  // no start within the window
  }
}

// Half-metre squares of a long wall of points 1 cm apart, also those shifted by half a square, have
// their means at multiples of 0.25 m and the least σ across, 3 cm. Of points there, on the wall, 1
// σ and 2 σ off it and in a square without points, the likelihoods are exp(0, −1/2, −2) and none.
TEST(Ndt, FiguresOfFourPoints) {
  PointSet wall, seen;
  for (int i = -400; i < 400; ++i) wall.push_back({0.01F * static_cast<float>(i) + 0.005F, 1.1F});
  const PlacedPoints placed{&wall, SE2d()};
  const auto map = NdtMap::make({&placed, 1});
  ASSERT_TRUE(map);
  for (const auto& [x, y] : {std::pair{-2.0F, 1.1F}, {-1.0F, 1.13F}, {1.0F, 1.16F}, {2.0F, 2.3F}})
    seen.push_back({x, y});
  const auto match = NdtMatcher({.max_iterations = 0}).match(*map, seen, SE2d(), kWindow);
  ASSERT_TRUE(match && *match);
  EXPECT_NEAR((*match)->score, (1.0 + std::exp(-0.5) + std::exp(-2.0)) / 4.0, 1e-4);
  EXPECT_NEAR((*match)->mean_log_likelihood, (-0.5 - 2.0 + std::log(0.01)) / 4.0, 1e-4);
}

/// The normalised squared error is χ² with three degrees of freedom if the covariance is
/// consistent, but Cauchy weights at one σ increase the variance of a mean of Gaussian errors
/// by 1.313 (E ψ² / (E ψ')², ψ = r / (1 + r²)): 3.79, ± three standard errors √(6 / 200) · 1.264 of
/// the mean.
TEST(Icp, CovarianceIsConsistentWithTheErrors) {
  Rng rng(37);
  const Walls room = Walls::room();
  double sum = 0;
  int n = 0;
  for (int i = 0; i < 200; ++i) {
    const SE2d at(rng.uniform(-2, 1.5), rng.uniform(-1, 1), Angle::radians(rng.uniform(-3, 3)));
    PointSet exact, noisy;
    const PointSet ideal = end_points(room.scan(at, rng, 0.0));
    for (std::size_t k = 0; k < ideal.size(); ++k) {
      exact.push_back(ideal[k]);
      noisy.push_back(ideal[k] +
                      Eigen::Vector2d(rng.normal(0, 0.01), rng.normal(0, 0.01)).cast<float>());
    }
    const PlacedPoints placed{&exact, at};
    const auto map = SurfaceMap::make({&placed, 1}, {.spacing_m = 0.001});
    ASSERT_TRUE(map);
    const auto match =
        IcpMatcher({.sigma_m = 0.01}).match(*map, noisy, at, kWindow, {.covariance = true});
    ASSERT_TRUE(match && *match);
    const Eigen::Vector3d e = (*match)->T_map_points.minus(at);
    sum += e.dot((*match)->covariance->inverse() * e);
    ++n;
  }
  EXPECT_NEAR(sum / n, 3.79, 0.66);
  RecordProperty("nees", std::to_string(sum / n));
}

}  // namespace
}  // namespace wayfare
