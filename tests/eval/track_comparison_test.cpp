#include <wayfare/eval/track_comparison.hpp>
#include <wayfare/eval/track_curve.hpp>

#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>

namespace wayfare::eval {
namespace {

using ::testing::HasSubstr;

/// A drive with turns and changing speed at time t.
Eigen::Vector3d drive(double t) {
  return {10.0 * t + 20.0 * std::sin(0.2 * t), 60.0 * std::sin(0.15 * t), 2.0 * std::sin(0.05 * t)};
}

Track track(double from_s, double to_s, double step_s, double clock_late_s = 0.0) {
  Track points;
  for (int i = 0; from_s + i * step_s <= to_s; ++i) {
    const double t = from_s + i * step_s;
    points.push_back({LogTime::from_seconds(t - clock_late_s), drive(t)});
  }
  return points;
}

TEST(TrackComparison, EqualTracksHaveNoErrors) {
  const auto c = compare_tracks(track(0, 100, 0.1), track(0, 100, 0.1));
  ASSERT_TRUE(c) << c.error().to_string();
  EXPECT_EQ(c->differences.size(), 1001U);
  for (const TrackDifference& d : c->differences) EXPECT_EQ(d.error_m.norm(), 0.0);
}

// The cubic's error is of third order in the step where slopes are those of parabolas: its bound
// with h = 1 s, |p'''| <= 20 · 0.2³ + 60 · 0.15³ = 0.37 m/s³ is h³ / (9 √3) · |p'''| / 6 … taken as
// 0.03 m.
TEST(TrackComparison, TheReferenceIsInterpolatedSmoothly) {
  const auto c = compare_tracks(track(2, 98, 0.1), track(0, 100, 1.0));
  ASSERT_TRUE(c);
  for (const TrackDifference& d : c->differences) EXPECT_LT(d.error_m.norm(), 0.03);
}

TEST(TrackComparison, ParabolasAreInterpolatedExactly) {
  Track curve;
  for (const double t : {0.0, 1.0, 1.5, 3.0, 4.0})
    curve.push_back({LogTime::from_seconds(t), {t * t, 1.0 - 2.0 * t, 0.5 * t * t}});
  const TrackCurve at(curve, std::chrono::seconds(10));
  for (int i = 0; i <= 40; ++i) {
    const double t = 0.1 * i;
    const auto p = at.at(LogTime::from_seconds(t));
    ASSERT_TRUE(p) << t;
    EXPECT_LT((*p - Eigen::Vector3d(t * t, 1.0 - 2.0 * t, 0.5 * t * t)).norm(), 1e-9) << t;
  }
  EXPECT_FALSE(at.at(LogTime::from_seconds(4.1)));
  EXPECT_FALSE(at.at(LogTime::from_seconds(-0.1)));
}

TEST(TrackComparison, ErrorsAreAlongLeftAndUp) {
  Track a = track(0, 60, 0.1), b = a;
  for (auto& at : a) {
    const double t = at.time.seconds();
    Eigen::Vector2d v(10.0 + 4.0 * std::cos(0.2 * t), 9.0 * std::cos(0.15 * t));
    v.normalize();
    at.position_m += Eigen::Vector3d(2.0 * v.x() - 0.5 * v.y(), 2.0 * v.y() + 0.5 * v.x(), -3.0);
  }
  const auto c = compare_tracks(a, b);
  ASSERT_TRUE(c);
  for (const TrackDifference& d : c->differences)
    EXPECT_LT((d.error_m - Eigen::Vector3d(2.0, 0.5, -3.0)).norm(), 0.02);
  const Table table = track_table(*c);
  EXPECT_EQ(table.rows()[0][1], "2.000");
  EXPECT_EQ(table.rows()[2][1], "-3.000");
  EXPECT_EQ(table.rows()[2][5], "3.000");
  EXPECT_EQ(track_table(*c, false).rows().size(), 3U);
}

/// Against the offset put in, for rates from 1 to 100 Hz, with and without noise and alignment.
TEST(TrackComparison, TheTimeOffsetIsFoundToAMillisecond) {
  const SE3d moved(Eigen::Vector3d(100.0, -50.0, 7.0),
                   SO3d::exp(Eigen::Vector3d(0.02, -0.03, 2.0)));
  for (const double late_s : {0.0, 0.317, -1.8, 4.4321}) {
    for (const double step_s : {0.01, 0.2, 1.0}) {
      for (const bool rigid : {false, true}) {
        Track a = track(10, 110, step_s, late_s);
        if (rigid)
          for (TrackPoint& p : a) p.position_m = moved * p.position_m;
        const auto c = compare_tracks(a, track(0, 120, 0.25), {rigid, 0.0, 5.0});
        ASSERT_TRUE(c);
        EXPECT_NEAR(c->offset_s, late_s, 1e-3) << step_s << rigid;
        EXPECT_FALSE(c->at_limit);
        EXPECT_GT(c->sharpness_mps2, 10.0);
      }
    }
  }
}

TEST(TrackComparison, AConstantDifferenceDoesNotMoveTheOffset) {
  Track a = track(10, 110, 0.1, 0.317);
  for (TrackPoint& p : a) p.position_m += Eigen::Vector3d(15.0, -8.0, 21.4);
  const auto c = compare_tracks(a, track(0, 120, 0.25), {false, 0.0, 3.0});
  ASSERT_TRUE(c);
  EXPECT_NEAR(c->offset_s, 0.317, 1e-3);
  EXPECT_NEAR(summarise(c->errors(2)).mean, 21.4, 0.01);
}

TEST(TrackComparison, NoiseMovesTheOffsetByItsStandardDeviation) {
  Rng rng(5);
  Track a = track(10, 110, 0.1, 0.5);
  for (TrackPoint& p : a) p.position_m += Eigen::Vector3d(rng.normal(), rng.normal(), rng.normal());
  const auto c = compare_tracks(a, track(0, 120, 0.25), {false, 0.0, 3.0});
  ASSERT_TRUE(c);
  // 1 m per axis, 1001 points, about 11 m/s: σ = 1 / (11 √1001) = 2.9 ms; four of them.
  EXPECT_NEAR(c->offset_s, 0.5, 0.0115);
}

TEST(TrackComparison, RigidAlignmentIsFound) {
  const SE3d T(Eigen::Vector3d(5.0, 6.0, -7.0), SO3d::exp(Eigen::Vector3d(0.1, 0.2, -2.5)));
  Track a = track(0, 100, 0.5);
  for (TrackPoint& p : a) p.position_m = T * p.position_m;
  const auto c = compare_tracks(a, track(0, 100, 0.5), {true});
  ASSERT_TRUE(c);
  EXPECT_LT((c->alignment * T).log().norm(), 1e-9);
  for (const TrackDifference& d : c->differences) EXPECT_LT(d.error_m.norm(), 1e-9);
}

TEST(TrackComparison, AlignmentOfALineAndOfAPointIsARotation) {
  Track line, point;
  for (int i = 0; i < 10; ++i) {
    line.push_back({LogTime::from_seconds(i), {1.0 * i, 0.0, 0.0}});
    point.push_back({LogTime::from_seconds(i), {3.0, 2.0, 1.0}});
  }
  for (const Track& b : {line, point}) {
    const auto c = compare_tracks(line, b, {true});
    ASSERT_TRUE(c);
    const Eigen::Matrix3d R = c->alignment.rotation().matrix();
    EXPECT_NEAR(R.determinant(), 1.0, 1e-9);
  }
}

TEST(TrackComparison, GapsOfTheReferenceAreLeftOut) {
  Track b = track(0, 100, 0.5);
  b.erase(b.begin() + 60, b.begin() + 100);  // 29.5 s to 50 s
  const auto c = compare_tracks(track(0, 100, 0.25), b);
  ASSERT_TRUE(c);
  for (const TrackDifference& d : c->differences) {
    const double t = d.time.seconds();
    EXPECT_TRUE(t < 29.51 || t > 49.99) << t;
  }
  const auto bridged = compare_tracks(track(0, 100, 0.25), b, {false, 0.0, 0.0, 30.0});
  ASSERT_TRUE(bridged);
  EXPECT_EQ(bridged->differences.size(), 401U);
}

TEST(TrackComparison, AtRestTheOffsetIsNotSharp) {
  Track a = track(0, 60, 0.5), b = a;
  for (Track* t : {&a, &b})
    for (TrackPoint& p : *t) p.position_m.setZero();
  const auto c = compare_tracks(a, b, {false, 0.0, 2.0});
  ASSERT_TRUE(c);
  EXPECT_LT(c->sharpness_mps2, 1e-9);
}

TEST(TrackComparison, BadInputIsNamed) {
  const Track good = track(0, 10, 0.5);
  const auto message = [&](const Track& a, const Track& b, const TrackComparisonOptions& o = {}) {
    const auto c = compare_tracks(a, b, o);
    return c ? std::string("no error") : c.error().message;
  };
  Track nan = good, back = good, twice = good, week = good, ms = good;
  nan[3].position_m.y() = std::numeric_limits<double>::quiet_NaN();
  back[4].time = back[2].time - std::chrono::milliseconds(1);
  twice[4].time = twice[3].time;
  for (TrackPoint& p : week) p.time += std::chrono::hours(24 * 7 * 2);
  for (TrackPoint& p : ms) p.time += std::chrono::seconds(20);
  EXPECT_THAT(message(nan, good), HasSubstr("the first track: point 4, at 1.500 s, is not finite"));
  EXPECT_THAT(message(good, back), HasSubstr("the second track: point 5, at 0.999 s, is earlier"));
  EXPECT_THAT(message(good, twice), HasSubstr("point 5, at 1.500 s, has the time of"));
  EXPECT_THAT(message(good, {}), HasSubstr("fewer than two points"));
  EXPECT_THAT(message(good, week), HasSubstr("about 2 GPS weeks apart"));
  EXPECT_THAT(message(good, ms), HasSubstr("do not overlap in time: the first is from 0.000 to "
                                           "10.000 s, the second from 20.000 to 30.000 s"));
  const double kNan = std::numeric_limits<double>::quiet_NaN();
  for (const TrackComparisonOptions& o : {TrackComparisonOptions{false, kNan},
                                          {false, 0.0, -1.0},
                                          {false, 0.0, kNan},
                                          {false, 0.0, 1e300},
                                          {false, 0.0, 0.0, -1.0}})
    EXPECT_THAT(message(good, good, o), HasSubstr("negative or not finite"));
}

}  // namespace
}  // namespace wayfare::eval
