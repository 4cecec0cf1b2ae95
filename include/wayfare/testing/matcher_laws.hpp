#pragma once

// The laws of the ScanMatcher and MappingMatcher concepts, as checks on any type:
//
//   TEST(MyMatcher, IsAMatcher) { wayfare::testing::MatcherLaws<MyMatcher>{}.check(); }

#include <cmath>
#include <concepts>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>

#include <gtest/gtest.h>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/random.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/match/scan_matcher.hpp>
#include <wayfare/testing/detail/law_room.hpp>

namespace wayfare::testing {

/// Fails the current test where a matcher does not find known offsets in a room, is not
/// deterministic or changes its map, leaves the window, accepts scores below the minimum, or
/// accepts invalid input.
template <ScanMatcher M>
struct MatcherLaws {
  using Map = typename M::Map;  ///< that the matcher reads

  M matcher{};  ///< under test
  /// The map of some scans: by `make_map`, if the matcher has it.
  std::function<Result<Map>(std::span<const PlacedPoints>)> map_of = {};
  /// Largest offset of the prior along an axis that must be found, m.
  double offset_m = 0.1;
  Angle turn = Angle::degrees(4);         ///< largest rotation of the prior that must be found
  double near_m = 0.05;                   ///< largest error of the position found, m
  Angle near_turn = Angle::degrees(0.6);  ///< largest error of the heading found
  double least_score = 0.5;               ///< of these matches
  double cell_m = 0.05;                   ///< by which the matcher rounds windows up
  int trials = 20;                        ///< offsets tried
  std::uint64_t seed = 1;                 ///< of the room's views and the offsets

  /// All laws.
  void check() {
    if constexpr (MappingMatcher<M>) {
      if (!map_of)
        map_of = [this](std::span<const PlacedPoints> scans) { return matcher.make_map(scans); };
    }
    ASSERT_TRUE(map_of) << "the matcher makes no maps, and map_of is not given";
    Rng rng(seed);
    const LawRoom::Views views(8, rng);
    const Result<Map> map = map_of(views.placed);
    ASSERT_TRUE(map) << map.error().to_string();
    check_offsets(*map, rng);
    check_window(*map, rng);
    check_score(*map, rng);
    check_repeated(*map, rng);
    check_input(*map, rng);
    if constexpr (MappingMatcher<M>) check_maps();
  }

 private:
  static constexpr SearchWindow kWindow{0.5, 0.5, Angle::degrees(20)};
  static constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

  /// Offsets from none up, at random places.
  void check_offsets(const Map& map, Rng& rng) {
    for (int trial = 0; trial < trials; ++trial) {
      SCOPED_TRACE("trial " + std::to_string(trial));
      const SE2d truth = LawRoom::place(rng);
      const double part = static_cast<double>(trial) / trials;
      const double reach_m = part * offset_m, reach = part * turn.radians();
      const SE2d prior = truth.plus({rng.uniform(-reach_m, reach_m), rng.uniform(-reach_m, reach_m),
                                     rng.uniform(-reach, reach)});
      const auto match =
          matcher.match(map, LawRoom::seen_from(truth, rng), prior, kWindow, {.covariance = true});
      ASSERT_TRUE(match) << match.error().to_string();
      ASSERT_TRUE(match->has_value()) << "no match";
      const Eigen::Vector3d error = (*match)->T_map_points.minus(truth);
      EXPECT_LT(error.head<2>().norm(), near_m);
      EXPECT_LT(std::abs(error[2]), near_turn.radians());
      EXPECT_GE((*match)->score, least_score);
      EXPECT_LE((*match)->score, 1.0);
      if ((*match)->covariance) expect_covariance(*(*match)->covariance);
    }
  }

  static void expect_covariance(const Eigen::Matrix3d& covariance) {
    ASSERT_TRUE(covariance.allFinite());
    EXPECT_TRUE(covariance.isApprox(covariance.transpose(), 1e-9));
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(covariance, Eigen::EigenvaluesOnly);
    EXPECT_GE(eigen.eigenvalues()[0], -1e-9 * covariance.norm());
  }

  void check_window(const Map& map, Rng& rng) {
    const SearchWindow narrow{0.05, 0.05, Angle::degrees(1)};
    for (int trial = 0; trial < trials; ++trial) {
      const SE2d truth = LawRoom::place(rng);
      const SE2d prior = truth.plus({0.2, -0.15, 0.06});
      const auto match = matcher.match(map, LawRoom::seen_from(truth, rng), prior, narrow, {});
      ASSERT_TRUE(match) << match.error().to_string();
      if (!*match) continue;
      const SE2d& pose = (*match)->T_map_points;
      const Eigen::Vector2d moved = (pose.translation() - prior.translation()).cwiseAbs();
      // A heading step moves the farthest point, less than 10 m away, by a cell.
      const double turned = std::abs((prior.inverse() * pose).heading().radians());
      EXPECT_LE(moved.x(), narrow.half_x_m + cell_m);
      EXPECT_LE(moved.y(), narrow.half_y_m + cell_m);
      EXPECT_LE(turned, narrow.half_heading.radians() + cell_m / 3.0);
    }
  }

  /// No score is that of a perfect match, for the points are noisy; none is good outside the map.
  void check_score(const Map& map, Rng& rng) {
    const SE2d truth = LawRoom::place(rng);
    const PointSet seen = LawRoom::seen_from(truth, rng);
    const auto perfect = matcher.match(map, seen, truth, kWindow, {.min_score = 0.9999});
    ASSERT_TRUE(perfect) << perfect.error().to_string();
    EXPECT_FALSE(perfect->has_value()) << "score " << (*perfect)->score << ", at least 0.9999";
    const auto nowhere =
        matcher.match(map, seen, SE2d(500, 500, Angle()), kWindow, {.min_score = 0.3});
    ASSERT_TRUE(nowhere) << nowhere.error().to_string();
    EXPECT_FALSE(nowhere->has_value()) << "a match 500 m outside the map";
  }

  /// The same match again, after another, and by a copy: neither the map nor the matcher has
  /// changed in a way that matters.
  void check_repeated(const Map& map, Rng& rng) {
    const SE2d truth = LawRoom::place(rng), elsewhere = LawRoom::place(rng);
    const PointSet seen = LawRoom::seen_from(truth, rng),
                   other = LawRoom::seen_from(elsewhere, rng);
    const SE2d prior = truth.plus({0.04, -0.03, 0.02});
    M copy = matcher;
    const auto first = matcher.match(map, seen, prior, kWindow, {});
    (void)matcher.match(map, other, elsewhere, kWindow, {.covariance = true});
    expect_same(first, matcher.match(map, seen, prior, kWindow, {}));
    expect_same(first, copy.match(map, seen, prior, kWindow, {}));
  }

  using Matched = Result<std::optional<MatchResult>>;

  static void expect_same(const Matched& a, const Matched& b) {
    ASSERT_TRUE(a && *a && b && *b) << "no match";
    const SE2d &p = (*a)->T_map_points, &q = (*b)->T_map_points;
    EXPECT_EQ(p.translation(), q.translation());
    EXPECT_EQ(p.rotation().cos(), q.rotation().cos());
    EXPECT_EQ(p.rotation().sin(), q.rotation().sin());
    EXPECT_EQ((*a)->score, (*b)->score);
  }

  void check_input(const Map& map, Rng& rng) {
    const PointSet good = LawRoom::seen_from(SE2d(), rng);
    PointSet bad = good;
    bad.push_back({std::numeric_limits<float>::quiet_NaN(), 1.0F});
    EXPECT_TRUE(matcher.match(map, good, SE2d(), kWindow, {}));
    EXPECT_FALSE(matcher.match(map, PointSet(), SE2d(), kWindow, {})) << "no points";
    EXPECT_FALSE(matcher.match(map, bad, SE2d(), kWindow, {})) << "a point of NaN";
    EXPECT_FALSE(matcher.match(map, good, SE2d(kNan, 0, Angle()), kWindow, {})) << "a prior of NaN";
    EXPECT_FALSE(matcher.match(map, good, SE2d(), {-1, 1, Angle()}, {})) << "a negative window";
    EXPECT_FALSE(matcher.match(map, good, SE2d(), {kNan, 1, Angle()}, {})) << "a window of NaN";
    MatchOptions options;
    options.prior_information = Eigen::Matrix3d::Constant(kNan);
    EXPECT_FALSE(matcher.match(map, good, SE2d(), kWindow, options)) << "information of NaN";
    if constexpr (std::default_initializable<Map>) {
      EXPECT_FALSE(matcher.match(Map{}, good, SE2d(), kWindow, {})) << "an empty map";
    }
  }

  void check_maps() {
    EXPECT_FALSE(matcher.make_map({})) << "a map of no scans";
    PointSet bad;
    bad.push_back({std::numeric_limits<float>::quiet_NaN(), 1.0F});
    const PlacedPoints scans[] = {{&bad, SE2d()}};
    EXPECT_FALSE(matcher.make_map(scans)) << "a map of a point of NaN";
  }
};

}  // namespace wayfare::testing
