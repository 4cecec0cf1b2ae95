// Localisation with a radar: metal in the walls distinguishes places that look alike to LiDAR.

#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/sensors/trajectory.hpp>
#include <wayfare/sim/simulate_recording.hpp>
#include <wayfare/sync/augmented_scans.hpp>

#include "localisation_support.hpp"
#include "sync/gather_radar.hpp"

namespace wayfare {
namespace {

constexpr double kReach_m = 6.0;
const SE2d kMount(0.08, 0.0, Angle{});
/// The symmetry of the place, 12 m x 2.5 m: a rotation by 180°.
const SE2d kHalfTurn(12.0, 2.5, Angle::degrees(180.0));

/// Radar detections from a pose: the reflectors in front of it, to 3 cm, and as many clutter
/// points.
RadarScan frame_at(LogTime time, const SE2d& T_map_base, const std::vector<Eigen::Vector2d>& metal,
                   Rng& rng) {
  RadarScan frame{time, {}};
  const SE2d T_radar_map = (T_map_base * kMount).inverse();
  const auto add = [&](double x, double y) {
    frame.points.push_back({.x_m = static_cast<float>(x), .y_m = static_cast<float>(y)});
  };
  for (const Eigen::Vector2d& at : metal) {
    const Eigen::Vector2d p = T_radar_map * at;
    if (p.norm() > kReach_m || p.x() < 0.0) continue;
    add(p.x() + 0.03 * rng.normal(), p.y() + 0.03 * rng.normal());
    add(rng.uniform(0.0, kReach_m), rng.uniform(-kReach_m, kReach_m));
  }
  return frame;
}

struct RadarPlace : Place {
  std::vector<Eigen::Vector2d> metal;
};

/// The place that is symmetric under rotation by 180°, with metal in its walls that is not.
const RadarPlace& symmetric() {
  static const RadarPlace place = [] {
    RadarPlace p{make_place(kSymmetric, 2), {}};
    Rng rng(3);
    for (int i = 0; i < 24; ++i) {
      const bool upper = rng.uniform() < 0.5;
      p.metal.emplace_back(rng.uniform(0.5, 11.5), upper ? 2.25 : 0.25);
    }
    OccupancyGrid seen({.resolution_m = 0.05});
    for (const Eigen::Vector2d& at : p.metal)
      seen.update(cell_of(at, 0.05), LogOdds::from_probability(0.95));
    p.map = *LocalisationMap::make(p.grid, {}, &seen);
    p.recording.T_base_radar = Transform2<frame::Base, frame::Radar>(kMount);
    const Trajectory& truth = p.recording.truth;
    for (LogTime t = truth.front().time; t < truth.back().time; t += Duration(50'000'000))
      p.recording.radar.push_back(frame_at(t, *pose_at(truth, t), p.metal, rng));
    return p;
  }();
  return place;
}

LocalisationOptions listening_to(bool lidar, bool radar) {
  LocalisationOptions options = quick();
  options.use_lidar = lidar;
  options.use_radar = radar;
  return options;
}

int found(const LocalisationOptions& options) {
  int found = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const auto result = run(symmetric().recording, symmetric(), options, {}, seed);
    const LocalisationOutcome& last = result.outcomes.back();
    const bool right = error_of(last, symmetric().recording).head<2>().norm() < 0.15;
    EXPECT_TRUE(right || !last.converged) << "converged at a wrong pose, seed " << seed;
    found += right && last.converged ? 1 : 0;
  }
  return found;
}

TEST(LocaliserWithRadar, ResolvesWhatIsAmbiguousToLidar) {
  EXPECT_EQ(found(listening_to(true, false)), 0);
  EXPECT_EQ(found(listening_to(true, true)), 4);
}

TEST(LocaliserWithRadar, FindsAndTracksWithRadarAlone) {
  EXPECT_EQ(found(listening_to(false, true)), 4);
  const Recording& recording = symmetric().recording;
  const auto result =
      run(recording, symmetric(), listening_to(false, true), known_start(recording));
  for (const LocalisationOutcome& o : result.outcomes) {
    EXPECT_EQ(o.sensor, RangeSensor::radar);
    EXPECT_LT(error_of(o, recording).head<2>().norm(), 0.3);
  }
  expect_found(result, recording);
}

// Started at the symmetric counterpart of the true pose, where LiDAR sees the same.
TEST(LocaliserWithRadar, RecoversFromAWrongInitialPose) {
  const Recording& recording = symmetric().recording;
  Gaussian<SE2d> start = known_start(recording);
  start.mean = kHalfTurn * start.mean;
  const auto blind = run(recording, symmetric(), listening_to(true, false), start);
  EXPECT_TRUE(blind.outcomes.back().converged);
  EXPECT_GT(error_of(blind.outcomes.back(), recording).head<2>().norm(), 1.0);
  expect_found(run(recording, symmetric(), listening_to(true, true), start), recording);
}

// Driven to and fro between the ends, and rotated by 180° without odometry.
TEST(LocaliserWithRadar, RecoversFromKidnappingToTheSymmetricPose) {
  Recording recording = symmetric().recording;
  const LogTime lifted = recording.truth[recording.truth.size() / 4].time;
  Rng rng(5);
  for (StampedPose& p : recording.truth)
    if (p.time >= lifted)
      p.T_map_base = Transform2<frame::Map, frame::Base>(kHalfTurn * p.T_map_base.raw());
  for (RadarScan& frame : recording.radar)
    if (frame.time > lifted + Duration(50'000'000))
      frame = frame_at(frame.time, *pose_at(recording.truth, frame.time), symmetric().metal, rng);
  const auto blind = run(recording, symmetric(), listening_to(true, false), known_start(recording));
  EXPECT_GT(error_of(blind.outcomes.back(), recording).head<2>().norm(), 1.0);
  expect_found(run(recording, symmetric(), listening_to(true, true), known_start(recording)),
               recording);
}

TEST(LocaliserWithRadar, ContinuesWithOneSensor) {
  Recording recording = symmetric().recording;
  const LogTime off = recording.scans[30].time, on = off + std::chrono::seconds(5);
  const auto silent = [&](const auto& s) { return s.time >= off && s.time < on; };
  Recording without_radar = recording, without_lidar = recording;
  std::erase_if(without_radar.radar, silent);
  std::erase_if(without_lidar.scans, silent);
  for (RadarPoint& p : without_lidar.radar[3].points) p.x_m = std::nanf("");
  for (const Recording* r : {&without_radar, &without_lidar}) {
    const auto result = run(*r, symmetric(), quick(), known_start(*r));
    EXPECT_EQ(result.refused_scans, 0U);
    for (const LocalisationOutcome& o : result.outcomes)
      EXPECT_LT(error_of(o, *r).head<2>().norm(), 0.3);
    expect_found(result, *r);
  }
}

TEST(LocaliserWithRadar, SameSeedSameBytesForAnyNumberOfThreads) {
  LocalisationOptions options = quick();
  const auto one = run(symmetric().recording, symmetric(), options);
  options.threads = 2;
  expect_same(one, run(symmetric().recording, symmetric(), options));
}

TEST(LocaliserWithRadar, RefusesInvalidScans) {
  PointSet points;
  for (int i = 0; i < 20; ++i) points.push_back({1.0F, 0.1F * static_cast<float>(i)});
  const Place plain = make_place(kSymmetric, 2);
  Localiser without(plain.map, quick(), 1);
  EXPECT_FALSE(without.add_radar(LogTime::from_seconds(1.0), points, {}));
  Localiser localiser(symmetric().map, quick(), 1);
  ASSERT_TRUE(localiser.add_radar(LogTime::from_seconds(1.0), points, {}));
  const auto before = localiser.particles();
  EXPECT_FALSE(localiser.add_radar(LogTime::from_seconds(0.5), points, {}));
  points.push_back({std::numeric_limits<float>::quiet_NaN(), 0.0F});
  EXPECT_FALSE(localiser.add_radar(LogTime::from_seconds(2.0), points, {}));
  const auto after = localiser.particles();
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t i = 0; i < after.size(); i += 100)
    EXPECT_EQ(after[i].T_map_base.translation(), before[i].T_map_base.translation());
}

// A robot rotating on the spot at a tenth of a radian per second sees one post, 2 m in front of it
// at the last frame.
TEST(GatherRadar, ExpressesFramesInTheBaseFrameOfTheLastOne) {
  Recording recording;
  recording.T_base_radar = Transform2<frame::Base, frame::Radar>(kMount);
  const auto pose = [](double t) { return SE2d(1.0, -2.0, Angle::radians(0.1 * t)); };
  const Eigen::Vector2d post = pose(1.0) * Eigen::Vector2d(2.0, 0.0);
  for (int i = 0; i <= 10; ++i) {
    const double t = 0.1 * i;
    const LogTime time = LogTime::from_seconds(t);
    recording.odometry.push_back({time, Transform2<frame::Odom, frame::Base>(pose(t))});
    const Eigen::Vector2d p = (pose(t) * kMount).inverse() * post;
    RadarScan frame{time, {{.x_m = static_cast<float>(p.x()), .y_m = static_cast<float>(p.y())}}};
    if (i == 5) frame.points[0].x_m = std::nanf("");
    recording.radar.push_back(frame);
  }
  GatherOptions options;
  options.longest_s = 5.0;
  const OdometryTrack track(recording.odometry);
  const auto one = gather_radar(recording, track, options);
  ASSERT_EQ(one.size(), 1U);
  EXPECT_EQ(one[0].time, LogTime::from_seconds(1.0));
  ASSERT_EQ(one[0].points.size(), 10U);  // the one that is not finite is left out
  for (std::size_t i = 0; i < 10; ++i) {
    EXPECT_NEAR(one[0].points[i].x(), 2.0F, 1e-5F);
    EXPECT_NEAR(one[0].points[i].y(), 0.0F, 1e-5F);
  }
  options.frames = 4;
  EXPECT_EQ(gather_radar(recording, track, options).size(), 3U);  // 4 + 4 + 3
  options.frames = 20;
  options.longest_s = 0.35;
  EXPECT_EQ(gather_radar(recording, track, options).size(), 3U);  // 0 … 0.3, 0.4 … 0.7, the rest
}

// Straight ahead at 0.25 m/s past a post at 30° to the left, whose Doppler is in the bin of speed
// 0: the sine of its bearing has an error from the radial speed towards it, v cos 30°.
TEST(GatherRadar, CorrectsBearingsForTheOdometryVelocity) {
  Recording recording;
  recording.radar_max_speed_m_s = 2.0;
  constexpr double kSpeed = 0.25;
  const RadarArray array{.max_speed_m_s = recording.radar_max_speed_m_s};
  const double seen = 0.5, cosine = std::sqrt(1.0 - seen * seen);
  const double sine = seen + array.sine_per_m_s() * kSpeed * cosine;
  for (int i = 0; i < 3; ++i) {
    const LogTime time = LogTime::from_seconds(0.1 * i);
    recording.odometry.push_back(
        {time, Transform2<frame::Odom, frame::Base>(SE2d(0.1 * i * kSpeed, 0.0, Angle{}))});
    recording.radar.push_back(
        {time, {{.x_m = static_cast<float>(3.0 * cosine), .y_m = static_cast<float>(3.0 * seen)}}});
  }
  ASSERT_GT(std::abs(seen - sine), 0.003);
  const auto scans = gather_radar(recording, OdometryTrack(recording.odometry), {1, 1.0});
  ASSERT_EQ(scans.size(), 3U);
  const auto gathered = gather_radar(recording, OdometryTrack(recording.odometry));
  ASSERT_EQ(gathered.size(), 1U);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(gathered[0].points[i].y(), 3.0 * sine, 1e-5);
  // A single frame has no velocity.
  EXPECT_NEAR(scans[0].points[0].y(), 3.0 * seen, 1e-5);
}

TEST(Kidnapped, AppliesToTheRadarToo) {
  const Recording& whole = symmetric().recording;
  const LogTime from = whole.truth[whole.truth.size() / 4].time;
  const LogTime to = whole.truth[whole.truth.size() / 2].time;
  const Recording carried = sim::kidnapped(whole, from, to);
  ASSERT_LT(carried.radar.size(), whole.radar.size());
  for (std::size_t i = 1; i < carried.radar.size(); ++i)
    EXPECT_GT(carried.radar[i].time, carried.radar[i - 1].time);
  EXPECT_EQ(carried.radar.back().time, whole.radar.back().time - (to - from));
  EXPECT_EQ(carried.T_base_radar.raw().x(), kMount.x());
}

}  // namespace
}  // namespace wayfare
