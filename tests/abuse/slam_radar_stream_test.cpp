// The stream of the particle filter: measurements that are none, times near the limits, recordings.

#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "abuse/slam_radar_support.hpp"

namespace wayfare::tests {
namespace {

TEST(AbusedRadarSlamStream, EmptyAndFinishedTwice) {
  for (const MotionSource source :
       {MotionSource::wheels, MotionSource::odometry, MotionSource::none}) {
    RadarSlamStreamOptions options{few_particles()};
    options.motion = source;
    RadarSlamStream stream(options);
    EXPECT_FALSE(stream.step());
    stream.finish();
    stream.finish();
    EXPECT_FALSE(stream.step());
    EXPECT_EQ(stream.waits_for(), "");
    EXPECT_TRUE(stream.result().trajectory.empty());
    EXPECT_FALSE(stream.map().bounds());
  }
}

// One measurement with a time far ahead: what follows in its stream is late and counted, nothing
// waits for ever, and the number of steps is bounded by the measurements.
TEST(AbusedRadarSlamStream, TimesAtTheLimits) {
  using Limits = std::numeric_limits<std::int64_t>;
  for (const MotionSource source : {MotionSource::odometry, MotionSource::none})
    for (const std::int64_t ns :
         {Limits::min(), Limits::min() + 1, Limits::max() - 1, Limits::max()}) {
      SCOPED_TRACE(ns);
      RadarSlamStreamOptions options{few_particles()};
      options.motion = source;
      RadarSlamStream stream(options);
      const LogTime time = LogTime::from_nanoseconds(ns);
      const auto measure = [&](LogTime t, int k) {
        stream.add(OdometrySample{t, Odometry(pose_of_drive(k))});
        stream.add(radar_of_drive(t, k));
        stream.add(scan_of_room(t, pose_of_drive(k)));
      };
      const auto steps = [&] {
        int n = 0;
        while (stream.step()) ++n;
        return n;
      };
      measure(time_of_drive(0), 0);
      steps();
      measure(time, 1);
      steps();
      for (int k = 2; k < 6; ++k) measure(time_of_drive(k), k);
      EXPECT_LT(steps(), 20);
      stream.finish();
      EXPECT_LT(steps(), 20);
      const RadarSlamRun result = stream.result();
      EXPECT_GT(result.refused_scans, 0U);
      EXPECT_TRUE(all_finite(numbers_of(result.trajectory)));
    }
}

TEST(AbusedRadarSlamStream, MeasurementsThatAreNone) {
  for (const MotionSource source :
       {MotionSource::wheels, MotionSource::odometry, MotionSource::none})
    for (const double bad : {kNan, kInf, -kInf, 1e9, 1e300}) {
      SCOPED_TRACE(bad);
      RadarSlamStreamOptions options{few_particles()};
      options.motion = source;
      options.sync.wheel_base_m = 0.4;
      RadarSlamStream stream(options);
      for (int k = 0; k < 12; ++k) {
        const LogTime now = time_of_drive(k);
        const bool now_bad = k % 3 == 2;
        stream.add(WheelSample{now, now_bad ? bad : 0.1, 0.1});
        stream.add(GyroSample{now, now_bad ? bad : 0.1});
        stream.add(OdometrySample{
            now, Odometry(now_bad ? SE2d(bad, 0.0, Angle::radians(bad)) : pose_of_drive(k))});
        RadarScan radar = radar_of_drive(now, k);
        if (now_bad) radar.points.front().x_m = static_cast<float>(bad);
        if (now_bad) radar.points.back().doppler_m_s = static_cast<float>(bad);
        stream.add(radar);
        stream.add(scan_of_drive(k));
        while (stream.step()) continue;
      }
      stream.finish();
      while (stream.step()) continue;
      const RadarSlamRun result = stream.result();
      EXPECT_TRUE(all_finite(numbers_of(result.trajectory)));
      EXPECT_GE(result.trajectory.size(), 8U);
      EXPECT_TRUE(std::isfinite(result.gyro_bias_rad_s));
    }
}

TEST(AbusedRadarSlamStream, LivesAsAValue) {
  const auto feed = [](RadarSlamStream& stream, int from, int to) {
    for (int k = from; k < to; ++k) {
      stream.add(OdometrySample{time_of_drive(k), Odometry(pose_of_drive(k))});
      stream.add(radar_of_drive(time_of_drive(k), k));
      stream.add(scan_of_drive(k));
      while (stream.step()) continue;
    }
  };
  const auto make = [&] {
    RadarSlamStream stream(RadarSlamStreamOptions{few_particles()});
    feed(stream, 0, 5);
    return stream;
  };
  const auto probe = [&](RadarSlamStream& stream) {
    feed(stream, 5, 9);
    stream.finish();
    while (stream.step()) continue;
    return numbers_of(stream.slam());
  };
  expect_move_semantics(make, probe);
  const auto results = in_two_threads([&](int) {
    RadarSlamStream stream = make();
    return probe(stream);
  });
  EXPECT_EQ(results[0], results[1]);
}

TEST(AbusedRadarSlamStream, Recordings) {
  for (const SlamSensors sensors : {SlamSensors::radar, SlamSensors::lidar, SlamSensors::both}) {
    Recording recording;
    EXPECT_FALSE(run_radar_slam(recording, few_particles(), sensors));
    recording.wheels = {{time_of_drive(0), 0.0, 0.0}};
    EXPECT_FALSE(run_radar_slam(recording, few_particles(), sensors));
    recording.wheels.clear();
    recording.scans = {scan_of_drive(0)};
    recording.radar = {radar_of_drive(time_of_drive(0), 0)};
    for (RadarPoint p : std::vector(recording.radar[0].points))
      recording.radar[0].points.push_back(p);
    const auto one = run_radar_slam(recording, few_particles(), sensors);
    EXPECT_TRUE(one);
    int calls = 0;
    for (int k = 1; k < 9; ++k) recording.scans.push_back(scan_of_drive(9 - k));
    const auto stopped =
        run_radar_slam(recording, few_particles(), sensors, [&](double) { return ++calls < 1; });
    EXPECT_EQ(calls, 1);
  }
}

}  // namespace
}  // namespace wayfare::tests
