#include <wayfare/sim/simulate_recording.hpp>

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

namespace wayfare::sim {
namespace {

const std::vector<Eigen::Vector2d> kSquareRoute = {{0, 0}, {8, 0}, {8, 8}, {0, 8}, {0, 0}, {8, 0}};

// At 1 m/s along x, a pose every 10 ms.
Trajectory straight(double length_m) {
  Trajectory truth;
  const int steps = static_cast<int>(std::lround(length_m * 100));
  for (int i = 0; i <= steps; ++i) {
    truth.push_back({LogTime::from_nanoseconds(i * 10'000'000LL),
                     Transform2<frame::Map, frame::Base>(SE2d(0.01 * i, 0.0, Angle{}))});
  }
  return truth;
}

// The sample variance of `runs` normal values has relative standard deviation √(2/(n-1)); five.
double spread(int runs) { return 5.0 * std::sqrt(2.0 / (runs - 1)); }

TEST(DriveRoute, RespectsItsLimitsAndRollsWithoutSideSlip) {
  const DriveParams params;
  const auto truth = drive_route(kSquareRoute, params);
  ASSERT_TRUE(truth.has_value()) << truth.error().to_string();
  const double dt = to_seconds(params.step);
  double speed = 0.0, turn = 0.0;
  for (std::size_t i = 1; i < truth->size(); ++i) {
    const StampedPose &a = (*truth)[i - 1], &b = (*truth)[i];
    ASSERT_EQ(b.time - a.time, params.step);
    const Eigen::Vector3d twist = b.T_map_base.raw().minus(a.T_map_base.raw()) / dt;
    EXPECT_NEAR(twist.y(), 0.0, 1e-9);
    EXPECT_GE(twist.x(), -1e-9);
    EXPECT_LE(twist.x(), params.max_speed_m_s + 1e-9);
    EXPECT_LE(std::abs(twist.z()), params.max_turn_rate_rad_s + 1e-9);
    EXPECT_LE(std::abs(twist.x() - speed), params.max_acceleration_m_s2 * dt + 1e-9);
    EXPECT_LE(std::abs(twist.z() - turn), params.max_turn_acceleration_rad_s2 * dt + 1e-9);
    speed = twist.x(), turn = twist.z();
  }
}

TEST(DriveRoute, PassesEveryWaypoint) {
  const DriveParams params;
  const auto truth = drive_route(kSquareRoute, params);
  ASSERT_TRUE(truth.has_value());
  for (const Eigen::Vector2d& waypoint : kSquareRoute) {
    double nearest = 1e9;
    for (const StampedPose& p : *truth)
      nearest = std::min(nearest, (p.T_map_base.raw().translation() - waypoint).norm());
    EXPECT_LE(nearest, params.waypoint_radius_m);
  }
}

TEST(DriveRoute, RefusesBadRoutes) {
  using Route = std::vector<Eigen::Vector2d>;
  EXPECT_FALSE(drive_route(Route{}).has_value());
  EXPECT_FALSE(drive_route(Route{{0, 0}}).has_value());
  const auto nan = drive_route(Route{{0, 0}, {NAN, 0}});
  ASSERT_FALSE(nan.has_value());
  EXPECT_NE(nan.error().message.find("waypoint 1"), std::string::npos);
  DriveParams hurried;
  hurried.timeout = from_seconds(1.0);
  const auto late = drive_route(kSquareRoute, hurried);
  ASSERT_FALSE(late.has_value());
  EXPECT_EQ(late.error().code, ErrorCode::degenerate);
}

TEST(DriveRoute, AcceptsRepeatedWaypoints) {
  const std::vector<Eigen::Vector2d> route = {{0, 0}, {0, 0}, {2, 0}, {2, 0}, {0, 0}};
  const auto truth = drive_route(route);
  ASSERT_TRUE(truth.has_value());
  EXPECT_LT(truth->back().T_map_base.raw().translation().norm(), 0.31);
}

TEST(Odometry, WithoutNoiseFollowsTheTruth) {
  const Trajectory truth = drive_route(kSquareRoute).value();
  WheelParams perfect;
  perfect.slip_m_per_sqrt_m = 0.0;
  Rng rng(1);
  // Sampled at every step, each piece is exactly an arc.
  const auto wheels = simulate_wheels(truth, from_seconds(0.01), perfect, rng);
  const auto odometry = dead_reckon(wheels, perfect.wheel_base_m);
  ASSERT_EQ(odometry.size(), truth.size());
  const SE2d start = truth.front().T_map_base.raw();
  for (std::size_t i = 0; i < truth.size(); i += 50) {
    const SE2d expected = start.inverse() * truth[i].T_map_base.raw();
    EXPECT_LT(odometry[i].T_odom_base.raw().minus(expected).norm(), 1e-8) << i;
  }
}

TEST(Odometry, ADifferenceOfWheelRadiiCurvesThePath) {
  // Over a straight path L the right wheel reports (1 + s) L: an arc of length (1 + s/2) L with the
  // heading change s L / b.
  WheelParams params;
  params.slip_m_per_sqrt_m = 0.0;
  params.right_scale = 1.002;
  Rng rng(1);
  const auto wheels = simulate_wheels(straight(20.0), from_seconds(0.1), params, rng);
  const SE2d end = dead_reckon(wheels, params.wheel_base_m).back().T_odom_base.raw();
  const double arc = 20.0 * 1.001, turn = 0.002 * 20.0 / 0.4;
  EXPECT_NEAR(end.heading().radians(), turn, 1e-9);
  EXPECT_NEAR(end.x(), arc * std::sin(turn) / turn, 1e-6);
  EXPECT_NEAR(end.y(), arc * (1 - std::cos(turn)) / turn, 1e-6);
}

TEST(Odometry, SlipSpreadsAsPredicted) {
  // Each wheel's error after L metres has variance σ² L. Heading: 2 σ² L / b². Along the path: σ² L
  // / 2. Across it, the integral of a heading that is a random walk: (2 σ² / b²) L³ / 3.
  const double length = 10.0, sigma = 0.002;
  WheelParams params;
  params.slip_m_per_sqrt_m = sigma;
  const Trajectory truth = straight(length);
  const int runs = 2000;
  double heading = 0, along = 0, across = 0;
  for (int run = 0; run < runs; ++run) {
    Rng rng = Rng(99).stream(static_cast<std::uint64_t>(run));
    const auto wheels = simulate_wheels(truth, from_seconds(0.1), params, rng);
    const SE2d end = dead_reckon(wheels, params.wheel_base_m).back().T_odom_base.raw();
    heading += std::pow(end.heading().radians(), 2);
    across += std::pow(end.y(), 2);
    double rolled = 0;
    for (const WheelSample& w : wheels) rolled += 0.5 * (w.left_m + w.right_m);
    along += std::pow(rolled - length, 2);
  }
  const double rate = 2 * sigma * sigma / (0.4 * 0.4);
  EXPECT_NEAR(heading / runs / (rate * length), 1.0, spread(runs));
  EXPECT_NEAR(along / runs / (0.5 * sigma * sigma * length), 1.0, spread(runs));
  EXPECT_NEAR(across / runs / (rate * std::pow(length, 3) / 3), 1.0, spread(runs));
}

TEST(Odometry, GyroHasBiasAndRandomWalk) {
  const double bias = 0.002, walk = 0.001;
  const Trajectory truth = straight(30.0);  // 30 s
  const int runs = 2000;
  double sum = 0, squares = 0;
  for (int run = 0; run < runs; ++run) {
    Rng rng = Rng(5).stream(static_cast<std::uint64_t>(run));
    double angle = 0;
    const auto gyro = simulate_gyro(truth, from_seconds(0.1), {bias, walk}, rng);
    for (std::size_t i = 1; i < gyro.size(); ++i)
      angle += gyro[i].turn_rate_rad_s * to_seconds(gyro[i].time - gyro[i - 1].time);
    sum += angle - bias * 30, squares += std::pow(angle - bias * 30, 2);
  }
  const double variance = walk * walk * 30;
  EXPECT_NEAR(sum / runs, 0.0, 5 * std::sqrt(variance / runs));
  EXPECT_NEAR(squares / runs / variance, 1.0, spread(runs));
}

TEST(Odometry, UsesTheGyrosHeadingOnRequest) {
  const Trajectory truth = drive_route(kSquareRoute).value();
  WheelParams bent;
  bent.slip_m_per_sqrt_m = 0.0;
  bent.left_scale = 0.98;
  Rng a(1), b(2);
  const auto wheels = simulate_wheels(truth, from_seconds(0.1), bent, a);
  const auto gyro = simulate_gyro(truth, from_seconds(0.1), {}, b);
  const auto heading_error = [&](const std::vector<OdometrySample>& odometry) {
    const SE2d expected =
        truth.front().T_map_base.raw().inverse() * true_pose_at(truth, odometry.back().time);
    return std::abs((odometry.back().T_odom_base.raw().inverse() * expected).heading().radians());
  };
  EXPECT_LT(heading_error(dead_reckon(wheels, gyro)), 1e-9);
  EXPECT_GT(heading_error(dead_reckon(wheels, bent.wheel_base_m)), 0.1);
}

TEST(TruePoseAt, InterpolatesAndHoldsTheEnds) {
  const Trajectory truth = straight(1.0);
  EXPECT_NEAR(true_pose_at(truth, LogTime::from_seconds(0.505)).x(), 0.505, 1e-12);
  EXPECT_EQ(true_pose_at(truth, LogTime::from_seconds(-1)).x(), 0.0);
  EXPECT_NEAR(true_pose_at(truth, LogTime::from_seconds(9)).x(), 1.0, 1e-12);
}

}  // namespace
}  // namespace wayfare::sim
