// The particle filter with measurements that arrive one by one gives the same result as with the
// recording.

#include <wayfare/slam/radar_slam.hpp>

#include <algorithm>
#include <functional>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "radar_slam_support.hpp"

namespace wayfare {
namespace {

/// The first 12 s.
const Recording& begin_of_room() {
  static const Recording recording = [] {
    Recording r = room();
    const auto cut = [end = r.truth.front().time + Duration(12'000'000'000)](auto& stream) {
      std::erase_if(stream, [&](const auto& sample) { return sample.time > end; });
    };
    cut(r.scans), cut(r.radar), cut(r.wheels), cut(r.gyro), cut(r.odometry);
    return r;
  }();
  return recording;
}

/// Arrival time of a measurement and the call that adds it.
using Arrival = std::pair<double, std::function<void(RadarSlamStream&)>>;

template <class Stream>
void arrive(std::vector<Arrival>& all, const Stream& measurements, double lag_s) {
  for (const auto& m : measurements)
    all.emplace_back(m.time.seconds() + lag_s, [&m](RadarSlamStream& to) { to.add(m); });
}

RadarSlamStream stream_of(const Recording& r, SlamSensors sensors, MotionSource motion) {
  RadarSlamStreamOptions options{few(), sensors, motion, {}, sync_params(r)};
  options.slam.T_base_laser = r.T_base_laser;
  return RadarSlamStream(options);
}

/// Each stream at its greatest lag; processed as early as possible.
RadarSlamRun live(const Recording& r, SlamSensors sensors, MotionSource motion) {
  std::vector<Arrival> all;
  arrive(all, r.wheels, 0.05), arrive(all, r.gyro, 0.0), arrive(all, r.odometry, 0.1);
  arrive(all, r.radar, 0.02), arrive(all, r.scans, 0.15);
  std::stable_sort(all.begin(), all.end(),
                   [](const Arrival& a, const Arrival& b) { return a.first < b.first; });
  RadarSlamStream stream = stream_of(r, sensors, motion);
  for (const Arrival& arrival : all) {
    arrival.second(stream);
    while (stream.step()) continue;
  }
  // At most the last radar frames wait for the end.
  EXPECT_GE(to_seconds(stream.slam().pose()->time - r.radar.front().time), 10.0);
  stream.finish();
  while (stream.step()) continue;
  EXPECT_EQ(stream.slam().pose()->T_map_base.raw().translation(),
            stream.slam().trajectory().back().T_map_base.raw().translation());
  EXPECT_EQ(stream.result().refused_scans, 0U);
  return stream.result();
}

TEST(RadarSlamStream, LiveWithWheelsEqualsTheRecording) {
  for (const SlamSensors sensors : {SlamSensors::radar, SlamSensors::both})
    EXPECT_EQ(bytes_of(live(begin_of_room(), sensors, MotionSource::wheels)),
              bytes_of(run(begin_of_room(), sensors)));
}

TEST(RadarSlamStream, LiveWithOdometryEqualsTheRecording) {
  Recording r = begin_of_room();
  r.wheels.clear();
  r.gyro.clear();
  for (const SlamSensors sensors : {SlamSensors::radar, SlamSensors::lidar, SlamSensors::both})
    EXPECT_EQ(bytes_of(live(r, sensors, MotionSource::odometry)), bytes_of(run(r, sensors)));
  r.odometry.clear();
  EXPECT_EQ(bytes_of(live(r, SlamSensors::both, MotionSource::none)),
            bytes_of(run(r, SlamSensors::both)));
}

TEST(RadarSlamStream, WaitsForTheDataOfAScan) {
  const Recording& r = begin_of_room();
  RadarSlamStream stream = stream_of(r, SlamSensors::both, MotionSource::odometry);
  EXPECT_FALSE(stream.step());
  EXPECT_EQ(stream.waits_for(), "");
  stream.add(r.scans.front());
  EXPECT_FALSE(stream.step());
  EXPECT_EQ(stream.waits_for(), "radar scans");
  std::size_t frames = 0;
  do stream.add(r.radar[frames++]);
  while (r.radar[frames - 1].time < r.scans.front().time);
  EXPECT_FALSE(stream.step());
  EXPECT_EQ(stream.waits_for(), "odometry");
  stream.finish();
  EXPECT_EQ(*stream.step(), r.scans.front().time);
}

TEST(RadarSlamStream, RefusesLateMeasurements) {
  const Recording& r = begin_of_room();
  RadarSlamStream stream = stream_of(r, SlamSensors::lidar, MotionSource::none);
  stream.add(r.scans[1]);
  EXPECT_TRUE(stream.step());
  stream.add(r.scans[1]);
  stream.add(r.scans[0]);
  stream.add(r.radar[0]);  // not in use
  EXPECT_FALSE(stream.step());
  EXPECT_EQ(stream.result().refused_scans, 2U);
  EXPECT_EQ(stream.result().trajectory.size(), 1U);
}

}  // namespace
}  // namespace wayfare
