#include <wayfare/system/radar_slam.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/eval/interpolation.hpp>
#include <wayfare/sim/worlds.hpp>

#include "support.hpp"

namespace wayfare {
namespace {

/// The first half minute of a round in the room, every sensor on.
const Recording& room() {
  static const Recording recording = [] {
    const Rng rng(1);
    const auto world = sim::make_world("room", rng);
    Recording r = sim::simulate_world(*world, sim::turtlebot(rng), rng).value();
    const LogTime end = r.truth.front().time + Duration(40'000'000'000);
    const auto cut = [&](auto& stream) {
      std::erase_if(stream, [&](const auto& sample) { return sample.time > end; });
    };
    cut(r.scans), cut(r.radar), cut(r.wheels), cut(r.gyro), cut(r.odometry), cut(r.truth);
    return r;
  }();
  return recording;
}

RadarSlamOptions few() {
  RadarSlamOptions options;
  options.particles = 8;
  return options;
}

/// Largest distance from the truth, both begun at the same pose.
double largest_error_m(const Trajectory& estimate, const Recording& recording) {
  double largest = 0;
  const SE2d start = *eval::pose_at(recording.truth, estimate.front().time);
  const SE2d T_map_truth = estimate.front().T_map_base.raw() * start.inverse();
  for (const StampedPose& p : estimate) {
    const auto truth = eval::pose_at(recording.truth, p.time);
    if (truth)
      largest = std::max(
          largest,
          (p.T_map_base.raw().translation() - (T_map_truth * *truth).translation()).norm());
  }
  return largest;
}

RadarSlamRun run(const Recording& recording, SlamSensors sensors) {
  auto slam = run_radar_slam(recording, few(), sensors);
  EXPECT_TRUE(slam) << slam.error().to_string();
  return *std::move(slam);
}

bool says(const RadarSlamRun& slam, const std::string& what) {
  return std::any_of(slam.faults.begin(), slam.faults.end(),
                     [&](const SensorFault& f) { return f.what.find(what) != std::string::npos; });
}

// 40 s at 0.25 m/s. What wheels and gyro alone are off by is below this in this stretch, so the
// bound is that no sensor makes it worse; rounds that need the sensors are in radar_slam_study.
constexpr double kClose_m = 0.35;

TEST(RadarSlam, FollowsTheRobotWithEitherSensorAndBoth) {
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

/// Everything a run gives, as numbers without rounding.
struct RunBytes {
  std::vector<double> poses, log_weights;
  std::vector<std::int16_t> lidar, radar;
  bool operator==(const RunBytes&) const = default;
};

std::vector<std::int16_t> bytes_of(const OccupancyGrid& map) {
  std::vector<std::int16_t> bytes;
  map.for_each_tile([&](const Cell& corner, std::span<const std::int16_t> cells) {
    bytes.push_back(static_cast<std::int16_t>(corner.x));
    bytes.push_back(static_cast<std::int16_t>(corner.y));
    bytes.insert(bytes.end(), cells.begin(), cells.end());
  });
  return bytes;
}

RunBytes bytes_of(const RadarSlamRun& slam) {
  RunBytes bytes{{}, slam.log_weights, bytes_of(slam.lidar_map), bytes_of(slam.radar_map)};
  for (const Trajectory* poses : {&slam.trajectory, &slam.particles})
    for (const StampedPose& p : *poses) {
      const SE2d T = p.T_map_base.raw();
      bytes.poses.insert(bytes.poses.end(), {T.x(), T.y(), T.rotation().cos(), T.rotation().sin()});
    }
  return bytes;
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

/// From the tenth to the twentieth second.
bool in_the_middle(LogTime t) {
  const double s = to_seconds(t - room().truth.front().time);
  return s >= 10 && s < 20;
}

TEST(RadarSlamFaults, NoRadarPoints) {
  Recording r = room();
  for (RadarScan& scan : r.radar)
    if (in_the_middle(scan.time)) scan.points.clear();
  const RadarSlamRun slam = run(r, SlamSensors::radar);
  EXPECT_LT(largest_error_m(slam.trajectory, r), kClose_m);
  EXPECT_TRUE(says(slam, "no radar points"));
  EXPECT_FALSE(says(slam, "LiDAR"));
}

TEST(RadarSlamFaults, LidarOff) {
  Recording r = room();
  std::erase_if(r.scans, [](const LaserScan& scan) { return in_the_middle(scan.time); });
  const RadarSlamRun slam = run(r, SlamSensors::both);
  EXPECT_LT(largest_error_m(slam.trajectory, r), kClose_m);
  EXPECT_TRUE(says(slam, "no LiDAR returns"));
}

TEST(RadarSlamFaults, WheelStuck) {
  Recording r = room();
  for (WheelSample& w : r.wheels)
    if (in_the_middle(w.time)) w.left_m = 0.0;
  const RadarSlamRun slam = run(r, SlamSensors::both);
  EXPECT_LT(largest_error_m(slam.trajectory, r), 2 * kClose_m);
  EXPECT_TRUE(says(slam, "left wheel stuck"));
  EXPECT_FALSE(says(slam, "right wheel"));
}

TEST(RadarSlamFaults, GyroNotANumber) {
  Recording r = room();
  for (GyroSample& g : r.gyro)
    if (in_the_middle(g.time)) g.turn_rate_rad_s = std::numeric_limits<double>::quiet_NaN();
  const RadarSlamRun slam = run(r, SlamSensors::both);
  EXPECT_LT(largest_error_m(slam.trajectory, r), kClose_m);
  EXPECT_TRUE(says(slam, "gyro"));
}

TEST(RadarSlamFaults, LateAndDoubledScansChangeNothing) {
  const auto scan = [](double t) { return room_scan(t, 2.0 + 0.1 * t, 2.0); };
  const Gaussian<SE2d> step{SE2d(0.1, 0, Angle{}), 1e-4 * Eigen::Matrix3d::Identity()};
  RadarSlam clean(few()), troubled(few());
  for (int t = 0; t < 6; ++t) {
    for (RadarSlam* slam : {&clean, &troubled}) {
      ASSERT_TRUE(slam->move(step));
      ASSERT_TRUE(slam->add_lidar(scan(t)));
    }
    const auto doubled = troubled.add_lidar(scan(t));
    ASSERT_FALSE(doubled);
    EXPECT_NE(doubled.error().message.find("not later"), std::string::npos);
    EXPECT_FALSE(troubled.add_lidar(scan(t - 0.5)));
    EXPECT_FALSE(troubled.add_radar(LogTime::from_seconds(t - 0.5), {}));
  }
  ASSERT_EQ(clean.trajectory().size(), troubled.trajectory().size());
  for (std::size_t i = 0; i < clean.trajectory().size(); ++i)
    EXPECT_EQ(clean.trajectory()[i].T_map_base.raw().translation(),
              troubled.trajectory()[i].T_map_base.raw().translation());
}

TEST(RadarSlam, RefusesWhatIsNoMeasurement) {
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
  EXPECT_FALSE(outcome->taken_up);
  EXPECT_TRUE(slam.add_lidar(room_scan(2, 3, 2)));
}

}  // namespace
}  // namespace wayfare
