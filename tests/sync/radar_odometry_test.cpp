// Odometry by wheels, gyro and radar: good, slipping, silent and missing wheels.

#include <wayfare/sync/radar_odometry.hpp>

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

namespace wayfare {
namespace {

/// Forward speed and turn rate at a time: an S with a stop in the middle.
Eigen::Vector2d driven_at(double t) {
  const double speed = 0.5 * std::clamp(std::abs(t - 10.0) - 1.0, 0.0, 1.0);
  return {speed, 0.8 * speed * std::sin(0.5 * t)};
}

/// A radar at an angle and off the centre, 25 frames a second of 30 static points each, whose
/// radial speeds are `radar_scale` times the true ones.
Recording s_curve(double duration_s = 20.0, double radar_scale = 1.0) {
  Recording r;
  r.wheel_base_m = 0.3;
  r.T_base_radar = Transform2<frame::Base, frame::Radar>(SE2d(0.2, -0.1, Angle::degrees(20.0)));
  Rng rng(3);
  SE2d pose;
  const double dt = 0.01;
  double left = 0.0, right = 0.0, turn = 0.0;
  for (int i = 0; i * dt <= duration_s; ++i) {
    const LogTime now = LogTime::from_seconds(100.0 + i * dt);
    const Eigen::Vector2d u = driven_at(i * dt);
    if (i % 5 == 0) {
      r.wheels.push_back({now, left, right});
      r.gyro.push_back({now, turn / 0.05});
      r.truth.push_back({now, Transform2<frame::Map, frame::Base>(pose)});
      left = right = turn = 0.0;
    }
    if (i % 4 == 0) {
      const Eigen::Vector2d at_radar(u[0] + 0.1 * u[1], 0.2 * u[1]);
      const Eigen::Vector2d v = r.T_base_radar.raw().rotation().inverse() * at_radar;
      RadarScan scan{now, {}};
      for (int k = 0; k < 30; ++k) {
        const double bearing = rng.uniform(-1.0, 1.0), range = rng.uniform(1.0, 5.0);
        const Eigen::Vector2d d(std::cos(bearing), std::sin(bearing));
        scan.points.push_back(
            {static_cast<float>(range * d.x()), static_cast<float>(range * d.y()), 0.0F,
             static_cast<float>(-radar_scale * v.dot(d) + 0.02 * rng.normal()), 15.0F});
      }
      r.radar.push_back(scan);
    }
    pose = pose.plus({u[0] * dt, 0.0, u[1] * dt});
    left += (u[0] - 0.5 * 0.3 * u[1]) * dt, right += (u[0] + 0.5 * 0.3 * u[1]) * dt;
    turn += u[1] * dt;
  }
  return r;
}

double error_at_end(const Recording& r) {
  const SE2d truth = r.truth.back().T_map_base.raw();
  return (r.odometry.back().T_odom_base.raw().translation() - truth.translation()).norm();
}

TEST(RadarOdometry, GoodWheelsStayGood) {
  const Recording r = s_curve();
  const RadarOdometry found = radar_odometry(r);
  EXPECT_EQ(found.slipped_s, 0.0);
  EXPECT_EQ(found.silent_s, 0.0);
  EXPECT_EQ(found.frames_without, 0U);
  ASSERT_EQ(found.wheels.size(), r.wheels.size());
  EXPECT_LT(error_at_end(with_radar_odometry(r)), 0.03);
}

TEST(RadarOdometry, ReplacesWheelsThatSlip) {
  Recording r = s_curve();
  for (WheelSample& w : r.wheels) {
    const double t = to_seconds(w.time - r.wheels.front().time);
    if (t > 2.0 && t < 6.0) w.left_m *= 2.0, w.right_m *= 2.0;
    if (t > 12.0 && t < 15.0) w.right_m *= 1.8;
  }
  const RadarOdometry found = radar_odometry(r);
  EXPECT_GT(found.slipped_s, 5.5);
  // 7 s, and twice: the time in which slip is noticed, 0.8 s, and that of the mean to return.
  EXPECT_LT(found.slipped_s, 7.0 + 2.0 * 0.8 + 2.0 * 1.4);
  EXPECT_LT(error_at_end(with_radar_odometry(r)), 0.25);
  Recording wheels = r;
  wheels.radar.clear();
  EXPECT_GT(error_at_end(with_radar_odometry(wheels)), 1.0);
}

double distance(const std::vector<WheelSample>& wheels) {
  double sum = 0.0;
  for (const WheelSample& w : wheels) sum += 0.5 * (w.left_m + w.right_m);
  return sum;
}

TEST(RadarOdometry, WheelsThatSlipAreReplacedFromTheBeginningOfSlip) {
  const Recording good = s_curve();
  Recording r = good;
  double excess_m = 0.0;
  for (WheelSample& w : r.wheels) {
    const double t = to_seconds(w.time - r.wheels.front().time);
    if (t > 14.0 && t < 14.3) excess_m += 0.5 * w.right_m, w.right_m *= 2.0;
  }
  ASSERT_GT(excess_m, 0.06);
  const RadarOdometry found = radar_odometry(r);
  const auto turn = [](const std::vector<WheelSample>& wheels) {
    double sum = 0.0;
    for (const WheelSample& w : wheels) sum += (w.right_m - w.left_m) / 0.3;
    return sum;
  };
  EXPECT_NEAR(distance(found.wheels), distance(good.wheels), 0.1 * excess_m);
  EXPECT_NEAR(turn(found.wheels), turn(good.wheels), 0.05 * excess_m / 0.15);
}

TEST(RadarOdometry, LearnsTheScaleOfTheRadarFromWheelsThatRoll) {
  const double scale = 0.96;
  const Recording good = s_curve(60.0, scale);
  Recording r = good;
  for (WheelSample& w : r.wheels) {
    const double t = to_seconds(w.time - r.wheels.front().time);
    if (t > 40.0 && t < 50.0) w.left_m *= 2.0, w.right_m *= 2.0;
  }
  const RadarOdometry found = radar_odometry(r);
  EXPECT_LT(found.radar_scale_sigma, 0.01);
  EXPECT_NEAR(found.radar_scale, scale, 3.0 * found.radar_scale_sigma);
  // 10 s at 0.5 m/s: by the radar's own scale 0.2 m would be missing.
  EXPECT_NEAR(distance(found.wheels), distance(good.wheels), 0.05);
  EXPECT_EQ(radar_odometry(good).slipped_s, 0.0);
}

TEST(RadarOdometry, NeedsNoWheels) {
  Recording r = s_curve();
  r.wheels.clear();
  const RadarOdometry found = radar_odometry(r);
  EXPECT_EQ(found.wheel_base_m, 0.3);
  EXPECT_NEAR(found.silent_s, 20.0, 0.2);
  EXPECT_LT(error_at_end(with_radar_odometry(r)), 0.1);
}

TEST(RadarOdometry, FillsASilenceOfTheWheels) {
  Recording r = s_curve();
  std::erase_if(r.wheels, [&](const WheelSample& w) {
    const double t = to_seconds(w.time - r.radar.front().time);
    return t > 3.0 && t < 5.0;
  });
  for (WheelSample& w : r.wheels)
    if (to_seconds(w.time - r.radar.front().time) > 18.0) w.left_m = NAN;
  const RadarOdometry found = radar_odometry(r);
  EXPECT_NEAR(found.silent_s, 4.0, 0.3);
  EXPECT_LT(error_at_end(with_radar_odometry(r)), 0.1);
}

TEST(RadarOdometry, KeepsTheSpeedWithoutEither) {
  Recording r = s_curve(8.0);
  r.wheels.clear();
  std::erase_if(r.radar, [&](const RadarScan& s) {
    const double t = to_seconds(s.time - LogTime::from_seconds(100.0));
    return t > 3.0 && t < 5.0;
  });
  const RadarOdometry found = radar_odometry(r);
  EXPECT_NEAR(found.unknown_s, 1.7, 0.2);
  EXPECT_LT(error_at_end(with_radar_odometry(r)), 0.2);
}

TEST(RadarOdometry, DependsOnTheTimeInWhichSlipIsNoticedAtMost) {
  const Recording whole = s_curve();
  Recording half = whole;
  const LogTime end = LogTime::from_seconds(106.0);
  std::erase_if(half.wheels, [&](const auto& w) { return w.time > end; });
  std::erase_if(half.radar, [&](const auto& s) { return s.time > end; });
  const RadarOdometry a = radar_odometry(half), b = radar_odometry(whole);
  ASSERT_LE(a.wheels.size(), b.wheels.size());
  for (std::size_t i = 0; i + 1 < a.wheels.size(); ++i) {
    EXPECT_EQ(a.wheels[i].left_m, b.wheels[i].left_m);
    EXPECT_EQ(a.wheels[i].right_m, b.wheels[i].right_m);
  }
  EXPECT_TRUE(radar_odometry(Recording{}).wheels.empty());
}

}  // namespace
}  // namespace wayfare
