#include <wayfare/slam/radar_slam.hpp>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include <gtest/gtest.h>

#include <wayfare/match/correlative.hpp>
#include <wayfare/match/gauss_newton.hpp>

#include "radar_slam_support.hpp"
#include "support.hpp"

namespace wayfare {
namespace {

// 40 s at 0.25 m/s. The drift of wheels and gyro alone is below this bound here, so the test is
// that no sensor makes it worse; drives that need the sensors are in radar_slam_study.
constexpr double kClose_m = 0.35;

TEST(RadarSlam, TracksWithEitherSensorAndBoth) {
  for (const SlamSensors sensors : {SlamSensors::radar, SlamSensors::lidar, SlamSensors::both}) {
    const RadarSlamRun slam = run(room(), sensors);
    EXPECT_LT(largest_error_m(slam.trajectory, room()), kClose_m);
    EXPECT_TRUE(slam.faults.empty()) << slam.faults.front().what;
    EXPECT_EQ(slam.refused_scans, 0U);
    EXPECT_EQ(slam.lidar_map.bounds().has_value(), sensors != SlamSensors::radar);
    EXPECT_EQ(slam.radar_map.bounds().has_value(), sensors != SlamSensors::lidar);
    EXPECT_GT(slam.statistics.matches, 10 * slam.statistics.matches_refused);
    EXPECT_EQ(slam.particles.size(), 8U);
  }
}

TEST(RadarSlam, GivesTheSameBytesForAnyNumberOfThreads) {
  const auto bytes = [](std::uint64_t seed, int threads) {
    RadarSlamOptions options = few();
    options.seed = seed;
    options.threads = threads;
    return bytes_of(run_radar_slam(room(), options, SlamSensors::both).value());
  };
  const RunBytes one = bytes(1, 1);
  ASSERT_FALSE(one.lidar.empty());
  ASSERT_FALSE(one.radar.empty());
  EXPECT_EQ(one, bytes(1, 1));
  EXPECT_EQ(one, bytes(1, 2));
  const RunBytes other = bytes(2, 1);
  EXPECT_NE(one.poses, other.poses);
  EXPECT_NE(one.lidar, other.lidar);
}

TEST(RadarSlam, NoNumberOfIndependentPointsMeansAll) {
  const auto bytes = [](double independent_points) {
    RadarSlamOptions options = few();
    options.lidar.independent_points = independent_points;
    return bytes_of(run_radar_slam(room(), options, SlamSensors::lidar).value());
  };
  EXPECT_EQ(bytes(0.0), bytes(1e9));
}

enum class Answer { match, error, nan, nan_score };

/// Ascends the field's gradient.
struct GradientMatcher {
  using Map = LikelihoodField;
  Answer answer = Answer::match;

  [[nodiscard]] Result<std::optional<MatchResult>> match(const LikelihoodField& field,
                                                         const PointSet& points, const SE2d& prior,
                                                         const SearchWindow&,
                                                         const MatchOptions& options) const {
    const auto found = refine(field, points, prior);
    if (answer == Answer::error || !found) return Error{ErrorCode::numerical, "no answer"};
    if (found->score < options.min_score) return std::optional<MatchResult>();
    MatchResult match;
    match.T_map_points = found->T_map_points;
    match.score = found->score;
    if (answer == Answer::nan)
      match.T_map_points = SE2d(std::numeric_limits<double>::quiet_NaN(), 0.0, Angle());
    if (answer == Answer::nan_score) match.score = std::numeric_limits<double>::quiet_NaN();
    return std::optional(match);
  }
};

template <class M>
RadarSlamRun run_by(const M& matcher, int threads = 1) {
  const Recording& r = room();
  RadarSlamStreamOptions options{
      few(), SlamSensors::lidar, MotionSource::wheels, {}, sync_params(r)};
  options.slam.T_base_laser = r.T_base_laser;
  options.slam.threads = threads;
  RadarSlamStream stream(matcher, options);
  for (const WheelSample& sample : r.wheels) stream.add(sample);
  for (const GyroSample& sample : r.gyro) stream.add(sample);
  for (const RadarScan& scan : r.radar) stream.add(scan);  // whose times divide the motion
  for (const LaserScan& scan : r.scans) stream.add(scan);
  stream.finish();
  while (stream.step()) continue;
  return stream.result();
}

TEST(RadarSlam, TracksByAnotherMatcher) {
  const RadarSlamRun slam = run_by(GradientMatcher());
  EXPECT_LT(largest_error_m(slam.trajectory, room()), kClose_m);
  EXPECT_GT(slam.statistics.matches, 10 * slam.statistics.matches_refused);
  EXPECT_EQ(bytes_of(slam), bytes_of(run_by(GradientMatcher(), 3)));
  EXPECT_EQ(bytes_of(run_by(CorrelativeMatcher())), bytes_of(run(room(), SlamSensors::lidar)));
}

/// Counts its searches.
struct CountingMatcher {
  using Map = LikelihoodField;
  std::shared_ptr<std::atomic<std::size_t>> searches =
      std::make_shared<std::atomic<std::size_t>>(0);
  CorrelativeMatcher matcher = {};

  [[nodiscard]] Result<std::optional<MatchResult>> match(const LikelihoodField& field,
                                                         const PointSet& points, const SE2d& prior,
                                                         const SearchWindow& window,
                                                         const MatchOptions& options) {
    ++*searches;
    return matcher.match(field, points, prior, window, options);
  }
};

// With a search for each of the eight particles there would be eight times as many.
TEST(RadarSlam, OneParticlesMatchIsRefinedInTheMapsOfTheOthers) {
  const CountingMatcher matcher;
  const RadarSlamRun slam = run_by(matcher);
  EXPECT_EQ(bytes_of(slam), bytes_of(run_by(CorrelativeMatcher())));
  EXPECT_GE(*matcher.searches, slam.statistics.updates - 1);
  EXPECT_LT(*matcher.searches, 2 * slam.statistics.updates);
  EXPECT_EQ(slam.statistics.matches + slam.statistics.matches_refused,
            8 * (slam.statistics.updates - 1));
}

TEST(RadarSlam, WithoutAMatchParticlesAreDrawnFromTheMotion) {
  const std::pair<Answer, const char*> answers[] = {
      {Answer::error, "scan: no answer"},
      {Answer::nan, "scan: the matcher's result is not finite: its pose"},
      {Answer::nan_score, "scan: the matcher's result is not finite: its score"}};
  for (const auto& [answer, reason] : answers) {
    const RadarSlamRun slam = run_by(GradientMatcher{answer}),
                       threads = run_by(GradientMatcher{answer}, 3);
    EXPECT_EQ(slam.statistics.matches, 0U);
    EXPECT_GT(slam.statistics.matches_refused, 0U);
    EXPECT_GE(slam.statistics.matcher_errors.count, slam.statistics.matches_refused);
    EXPECT_EQ(slam.statistics.matcher_errors.first, reason);
    EXPECT_EQ(threads.statistics.matcher_errors.count, slam.statistics.matcher_errors.count);
    EXPECT_EQ(threads.statistics.matcher_errors.first, reason);
    for (const StampedPose& p : slam.trajectory)
      ASSERT_TRUE(p.T_map_base.raw().translation().allFinite());
  }
}

// The motion expects the robot where it was; the second scan fits half a metre to its left, as
// where shelves were moved.
RadarSlam after_a_false_match(const MatchGate& gate) {
  RadarSlamOptions options = few();
  options.lidar.gate = gate;
  RadarSlam slam(options);
  EXPECT_TRUE(slam.add_lidar(room_scan(0, 3, 2)));
  const Eigen::Vector3d sigma(0.3, 0.3, 0.1);
  EXPECT_TRUE(slam.move({SE2d(0.1, 0.0, Angle()), sigma.cwiseAbs2().asDiagonal()}));
  EXPECT_TRUE(slam.add_lidar(room_scan(1, 3.1, 2.5)));
  return slam;
}

TEST(RadarSlam, AGateRejectsFalseMatches) {
  const auto lateral_m = [](const RadarSlam& slam) {
    return slam.trajectory().back().T_map_base.raw().y();
  };
  const RadarSlam open = after_a_false_match({});
  EXPECT_EQ(open.statistics().matches, 8U);
  EXPECT_EQ(open.statistics().matches_gated, 0U);
  EXPECT_NEAR(lateral_m(open), 0.5, 0.1);
  const RadarSlam gated = after_a_false_match({.lateral_m = 0.4});
  EXPECT_EQ(gated.statistics().matches, 0U);
  EXPECT_EQ(gated.statistics().matches_refused, 8U);
  EXPECT_GE(gated.statistics().matches_gated, 8U);
  const RadarSlam wider = after_a_false_match({.lateral_m = 0.6});
  EXPECT_EQ(wider.statistics().matches, 8U) << "0.5 m to the side is within 0.6 m";
  EXPECT_EQ(wider.statistics().matches_gated, 0U);
}

TEST(RadarSlam, AGateRejectsTurns) {
  const auto gated = [](Angle limit) {
    RadarSlamOptions options = few();
    options.lidar.gate.turn = limit;
    RadarSlam slam(options);
    EXPECT_TRUE(slam.add_lidar(room_scan(0, 3, 2)));
    EXPECT_TRUE(slam.move({SE2d(), (Eigen::Vector3d(0.1, 0.1, 0.1).cwiseAbs2()).asDiagonal()}));
    LaserScan turned = room_scan(6, 3, 2);
    turned.first_bearing = turned.first_bearing - Angle::degrees(12.0);
    EXPECT_TRUE(slam.add_lidar(turned));
    return slam.statistics().matches_gated;
  };
  EXPECT_EQ(gated(Angle::degrees(15.0)), 0U);
  EXPECT_GE(gated(Angle::degrees(10.0)), 8U);
}

// Every particle's path ends at its pose; the best one's is the run's.
TEST(RadarSlam, GivesThePathsOfAllParticlesOnRequest) {
  RadarSlamOptions options = few();
  EXPECT_TRUE(run_radar_slam(room(), options, SlamSensors::radar).value().paths.empty());
  options.keep_paths = true;
  options.resample_below = 1e-9;
  const RadarSlamRun slam = run_radar_slam(room(), options, SlamSensors::radar).value();
  EXPECT_EQ(slam.statistics.resampled, 0U);
  ASSERT_EQ(slam.paths.size(), slam.particles.size());
  std::size_t same = 0;
  for (std::size_t i = 0; i < slam.paths.size(); ++i) {
    ASSERT_EQ(slam.paths[i].size(), slam.trajectory.size());
    const SE2d& middle = slam.paths[i][slam.paths[i].size() / 2].T_map_base.raw();
    same += middle.minus(slam.trajectory[slam.trajectory.size() / 2].T_map_base.raw()).norm() == 0;
  }
  EXPECT_EQ(same, 1U) << "without resampling no two particles share a path";
}

TEST(RadarSlam, RefusesInvalidMeasurements) {
  RadarSlam slam(few());
  LaserScan empty;
  EXPECT_FALSE(slam.add_lidar(empty));
  LaserScan turned = room_scan(0, 3, 2);
  turned.first_bearing = Angle::radians(std::numeric_limits<double>::quiet_NaN());
  EXPECT_FALSE(slam.add_lidar(turned));
  EXPECT_TRUE(slam.particles().empty());
  Gaussian<SE2d> lost{SE2d(), Eigen::Matrix3d::Identity()};
  lost.covariance(0, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(slam.move(lost));
  EXPECT_FALSE(run_radar_slam(Recording(), {}, SlamSensors::both));
  LaserScan blind = room_scan(1, 3, 2);
  std::fill(blind.ranges_m.begin(), blind.ranges_m.end(), std::numeric_limits<float>::quiet_NaN());
  const auto outcome = slam.add_lidar(blind);
  ASSERT_TRUE(outcome);
  EXPECT_FALSE(outcome->updated);
  EXPECT_TRUE(slam.add_lidar(room_scan(2, 3, 2)));
}

}  // namespace
}  // namespace wayfare
