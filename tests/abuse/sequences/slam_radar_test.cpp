// Random calls of the particle filter and of its stream, against a model of what is accepted and a
// twin that sees nothing else.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>

#include "abuse/slam_radar_support.hpp"

namespace wayfare::tests {
namespace {

TEST(RadarSlamSequence, RefusalsLeaveNoTrace) {
  constexpr int kSchedules = 200, kCalls = 24;
  for (std::uint64_t seed = 0; seed < kSchedules; ++seed) {
    Rng rng(seed);
    std::string calls = "seed " + std::to_string(seed);
    RadarSlamOptions options = few_particles();
    options.match_skipped = seed % 2 == 0;
    auto slam = std::make_unique<RadarSlam>(options);
    RadarSlam twin(options);
    std::array<std::optional<LogTime>, 2> last;  // of LiDAR and radar
    std::optional<LogTime> last_of_all;
    std::size_t scans = 0;
    int k = 1 + static_cast<int>(rng.below(60));
    for (int i = 0; i < kCalls; ++i) {
      const std::uint64_t what = rng.below(14), which = rng.below(2);
      calls += "; " + std::to_string(what) + "." + std::to_string(which) + "@" + std::to_string(k);
      SCOPED_TRACE(calls);
      const auto add = [&](LogTime time, bool valid, const LaserScan& scan,
                           const PointSet& points) {
        const bool expected = valid && !(last[which] && time <= *last[which]) &&
                              !(last_of_all && time < *last_of_all);
        const auto to = [&](RadarSlam& s) {
          return which == 0 ? s.add_lidar(scan) : s.add_radar(time, points);
        };
        const auto outcome = to(*slam);
        if (expected) {
          last[which] = last_of_all = time;
          ++scans;
          const auto same = to(twin);
          ASSERT_EQ(outcome.has_value(), same.has_value());
        } else {
          ASSERT_FALSE(outcome);
        }
      };
      Gaussian<SE2d> motion = motion_of_drive(k);
      LaserScan scan = scan_of_drive(k);
      PointSet points = detections_of_drive(k);
      if (what < 4) {
        ASSERT_TRUE(slam->move(motion) && twin.move(motion));
        ++k;
      } else if (what == 4) {
        motion.covariance(0, 1) = motion.covariance(1, 0) = 5e-4;
        ASSERT_FALSE(slam->move(motion));
      } else if (what == 5) {
        motion.mean = SE2d(kNotFinite[rng.below(3)], 0.0, Angle{});
        ASSERT_FALSE(slam->move(motion));
      } else if (what == 6) {
        motion.covariance.setZero();
        ASSERT_TRUE(slam->move(motion) && twin.move(motion));
      } else if (what == 7) {
        scan.ranges_m.assign(kBeams, NAN);
        add(scan.time, true, scan, {});
      } else if (what == 8) {
        scan.bearing_step = Angle::radians(kNotFinite[rng.below(3)]);
        points.push_back({NAN, 0.0F});
        add(scan.time, false, scan, points);
      } else if (what == 9) {
        scan.time = scan.time - Duration(static_cast<std::int64_t>(rng.below(500'000'000)));
        add(scan.time, true, scan, points);
      } else if (what == 10) {
        points.push_back({1e9F, static_cast<float>(rng.normal(0.0, 1e6))});
        scan.ranges_m.front() = 1e30F;
        add(scan.time, true, scan, points);
      } else {
        add(scan.time, true, scan, points);
      }
      if (rng.below(12) == 0) slam = std::make_unique<RadarSlam>(std::move(*slam));
      ASSERT_EQ(slam->statistics().scans, scans);
    }
    SCOPED_TRACE(calls);
    ASSERT_EQ(slam->trajectory().size(), scans);
    ASSERT_EQ(numbers_of(*slam), numbers_of(twin));
    ASSERT_TRUE(all_finite(numbers_of(slam->trajectory())));
    ASSERT_LT(slam->radar_map().tiles().tile_count(), 50U);
  }
}

// With odometry poses: a measurement is late if it is not later than the last of its stream, or
// earlier than the last one processed.
TEST(RadarSlamStreamSequence, LateMeasurementsLeaveNoTrace) {
  constexpr int kSchedules = 150, kCalls = 30;
  for (std::uint64_t seed = 0; seed < kSchedules; ++seed) {
    Rng rng(seed);
    std::string calls = "seed " + std::to_string(seed);
    RadarSlamStreamOptions options{few_particles()};
    options.motion = seed % 3 == 0 ? MotionSource::none : MotionSource::odometry;
    auto stream = std::make_unique<RadarSlamStream>(options);
    RadarSlamStream twin(options);
    std::array<std::optional<LogTime>, 3> last;
    std::optional<LogTime> processed;
    std::size_t late = 0;
    int k = 1 + static_cast<int>(rng.below(60));
    for (int i = 0; i < kCalls; ++i) {
      const std::uint64_t what = rng.below(8), shift = rng.below(6);
      LogTime time = time_of_drive(k);
      if (shift == 0) time = time - Duration(static_cast<std::int64_t>(rng.below(900'000'000)));
      if (shift == 1) time = time + Duration(static_cast<std::int64_t>(rng.below(900'000'000)));
      calls += "; " + std::to_string(what) + "@" + std::to_string(time.seconds());
      SCOPED_TRACE(calls);
      const auto add = [&](std::size_t of, const auto& measurement) {
        stream->add(measurement);
        if (of == 0 && options.motion == MotionSource::none) return;
        if ((last[of] && time <= *last[of]) || (processed && time < *processed)) {
          ++late;
        } else {
          last[of] = time;
          twin.add(measurement);
        }
      };
      if (what < 3) {
        SE2d pose = pose_of_drive(k);
        if (rng.below(8) == 0) pose = SE2d(kNotFinite[rng.below(3)], 0.0, Angle{});
        if (rng.below(8) == 0) pose = SE2d(1e9, 1e9, Angle{});
        add(0, OdometrySample{time, Odometry(pose)});
      } else if (what < 5) {
        RadarScan radar = radar_of_drive(time, k);
        if (rng.below(4) == 0) radar.points.clear();
        if (rng.below(4) == 0) radar.points.push_back({NAN, 0.0F, 0.0F, NAN, 0.0F});
        if (rng.below(4) == 0) radar.points.push_back({1e30F, 0.0F, 0.0F, 1e30F, 0.0F});
        add(1, radar);
      } else if (what < 7) {
        LaserScan scan = scan_of_room(time, pose_of_drive(k));
        if (rng.below(4) == 0) scan.ranges_m.assign(kBeams, NAN);
        if (rng.below(8) == 0) scan.ranges_m.clear();
        add(2, scan);
        ++k;
      } else if (rng.below(4) == 0) {
        calls += " finish";
        stream->finish();
        twin.finish();
      }
      if (rng.below(3) == 0) {
        while (const auto reached = stream->step()) {
          ASSERT_EQ(twin.step(), reached);
          ASSERT_TRUE(!processed || *reached >= *processed);
          processed = *reached;
        }
        ASSERT_FALSE(twin.step());
        ASSERT_EQ(stream->waits_for(), twin.waits_for());
      }
      if (rng.below(12) == 0) stream = std::make_unique<RadarSlamStream>(std::move(*stream));
    }
    SCOPED_TRACE(calls);
    stream->finish();
    twin.finish();
    int steps = 0;
    while (stream->step()) ASSERT_LE(++steps, kCalls);
    while (twin.step()) continue;
    const RadarSlamRun a = stream->result(), b = twin.result();
    ASSERT_EQ(a.refused_scans, b.refused_scans + late);
    ASSERT_EQ(numbers_of(stream->slam()), numbers_of(twin.slam()));
    ASSERT_TRUE(all_finite(numbers_of(a.trajectory)));
    ASSERT_LT(a.radar_map.tiles().tile_count(), 200U);
  }
}

// With wheels: whatever arrives, every pose is finite, time only goes on, and the same calls give
// the same bytes.
TEST(RadarSlamStreamSequence, WheelsOfAnyKind) {
  constexpr int kSchedules = 60, kCalls = 60;
  const auto run = [&](std::uint64_t seed) {
    Rng rng(seed);
    RadarSlamStreamOptions options{few_particles()};
    options.motion = MotionSource::wheels;
    options.sync.wheel_base_m = rng.below(4) == 0 ? 0.0 : 0.4;
    RadarSlamStream stream(options);
    std::optional<LogTime> reached;
    int k = 1;
    const auto step = [&] {
      while (const auto time = stream.step()) {
        EXPECT_TRUE(!reached || *time >= *reached);
        reached = time;
      }
    };
    for (int i = 0; i < kCalls; ++i) {
      LogTime time = time_of_drive(k);
      if (rng.below(8) == 0)
        time = time + Duration(static_cast<std::int64_t>(rng.below(400'000'000)));
      if (rng.below(8) == 0)
        time = time - Duration(static_cast<std::int64_t>(rng.below(900'000'000)));
      const double value = rng.below(10) == 0   ? kNotFinite[rng.below(3)]
                           : rng.below(20) == 0 ? rng.normal(0.0, 1e6)
                                                : rng.uniform(0.0, 0.2);
      switch (rng.below(6)) {
        case 0:
        case 1:
          stream.add(WheelSample{time, value, 0.1});
          break;
        case 2:
          stream.add(GyroSample{time, value});
          break;
        case 3:
          stream.add(radar_of_drive(time, k));
          break;
        case 4:
          stream.add(scan_of_room(time, pose_of_drive(k)));
          break;
        default:
          ++k;
      }
      if (rng.below(3) == 0) step();
    }
    stream.finish();
    step();
    const RadarSlamRun result = stream.result();
    EXPECT_TRUE(all_finite(numbers_of(result.trajectory)));
    EXPECT_TRUE(std::isfinite(result.gyro_bias_rad_s));
    return numbers_of(stream.slam());
  };
  for (std::uint64_t seed = 0; seed < kSchedules; ++seed) {
    SCOPED_TRACE(seed);
    ASSERT_EQ(run(seed), run(seed));
  }
}

}  // namespace
}  // namespace wayfare::tests
