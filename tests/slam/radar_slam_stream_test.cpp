// The particle filter fed as a robot gives its measurements: what comes of it is what comes of the
// recording.

#include <wayfare/slam/radar_slam_stream.hpp>

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

/// When it comes, and where it goes.
using Arrival = std::pair<double, std::function<void(RadarSlamStream&)>>;

template <class Stream>
void arrive(std::vector<Arrival>& all, const Stream& measurements, double lag_s) {
  for (const auto& m : measurements)
    all.emplace_back(m.time.seconds() + lag_s, [&m](RadarSlamStream& to) { to.add(m); });
}

RadarSlamStream stream_of(const Recording& r, SlamSensors sensors, MotionFrom motion) {
  RadarSlamStreamOptions options{few(), sensors, motion, {}, sync_params(r)};
  options.slam.T_base_laser = r.T_base_laser;
  return RadarSlamStream(options);
}

/// Each stream late by as much as it may be; worked on as soon as it can be.
RadarSlamRun live(const Recording& r, SlamSensors sensors, MotionFrom motion) {
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
  // No more than the last frames of the radar waits for its end.
  EXPECT_GE(to_seconds(stream.slam().pose()->time - r.radar.front().time), 10.0);
  stream.finish();
  while (stream.step()) continue;
  EXPECT_EQ(stream.slam().pose()->T_map_base.raw().translation(),
            stream.slam().trajectory().back().T_map_base.raw().translation());
  EXPECT_EQ(stream.result().refused_scans, 0U);
  return stream.result();
}

TEST(RadarSlamStream, GivesLiveByWheelsWhatTheRecordingGives) {
  for (const SlamSensors sensors : {SlamSensors::radar, SlamSensors::both})
    EXPECT_EQ(bytes_of(live(begin_of_room(), sensors, MotionFrom::wheels)),
              bytes_of(run(begin_of_room(), sensors)));
}

TEST(RadarSlamStream, GivesLiveByOdometryWhatTheRecordingGives) {
  Recording r = begin_of_room();
  r.wheels.clear();
  r.gyro.clear();
  for (const SlamSensors sensors : {SlamSensors::radar, SlamSensors::lidar, SlamSensors::both})
    EXPECT_EQ(bytes_of(live(r, sensors, MotionFrom::odometry)), bytes_of(run(r, sensors)));
  r.odometry.clear();
  EXPECT_EQ(bytes_of(live(r, SlamSensors::both, MotionFrom::nothing)),
            bytes_of(run(r, SlamSensors::both)));
}

TEST(RadarSlamStream, WaitsForWhatBelongsToAScan) {
  const Recording& r = begin_of_room();
  RadarSlamStream stream = stream_of(r, SlamSensors::both, MotionFrom::odometry);
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

TEST(RadarSlamStream, RefusesWhatComesTooLate) {
  const Recording& r = begin_of_room();
  RadarSlamStream stream = stream_of(r, SlamSensors::lidar, MotionFrom::nothing);
  stream.add(r.scans[1]);
  EXPECT_TRUE(stream.step());
  stream.add(r.scans[1]);
  stream.add(r.scans[0]);
  stream.add(r.radar[0]);  // not listened to
  EXPECT_FALSE(stream.step());
  EXPECT_EQ(stream.result().refused_scans, 2U);
  EXPECT_EQ(stream.result().trajectory.size(), 1U);
}

}  // namespace
}  // namespace wayfare
