#pragma once

// A robot's recording in memory, to be written.

#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/ros/recording.hpp>

namespace wayfare::testing {

/// `scans` scans, odometry, gyro and true poses at 10 Hz, radar frames at half of that; numbers
/// with arbitrary bits.
inline Recording sample_run(int scans) {
  Rng rng(5);
  Recording r;
  r.T_base_laser = Transform2<frame::Base, frame::Laser>(SE2d(0.21, -0.03, Angle::radians(0.02)));
  r.T_base_radar = Transform2<frame::Base, frame::Radar>(SE2d(0.3, 0.1, Angle::degrees(30.0)));
  for (int i = 0; i < scans; ++i) {
    const auto time = LogTime::from_nanoseconds(1'700'000'000'123'456'789 + 100'000'003LL * i);
    LaserScan scan{time, Angle::degrees(-120.0), Angle::degrees(0.5), 0.1F, 30.0F, {}};
    for (int k = 0; k < 481; ++k) scan.ranges_m.push_back(static_cast<float>(32.0 * rng.uniform()));
    r.scans.push_back(scan);
    const Angle heading = Angle::radians(3.1 * std::sin(0.01 * i));
    r.odometry.push_back({time, Transform2<frame::Odom, frame::Base>(
                                    SE2d(rng.uniform(), 0.1 * i + rng.uniform(), heading))});
    r.gyro.push_back({time, rng.uniform() - 0.5});
    r.truth.push_back({time + Duration(3), Transform2<frame::Map, frame::Base>(
                                               SE2d(rng.uniform(), rng.uniform(), heading))});
    if (i % 2 != 0) continue;
    RadarScan radar{time + Duration(7), {}};
    for (int k = i % 5; k > 0; --k)
      radar.points.push_back({static_cast<float>(rng.uniform()), 1.5F, -0.25F,
                              static_cast<float>(rng.uniform()), 12.0F});
    r.radar.push_back(radar);
  }
  return r;
}

//! [write]
inline void write_sample(const std::string& path, const Recording& recording) {
  auto writer = ros::RecordingWriter::create(path);
  ASSERT_TRUE(writer) << writer.error().to_string();
  const auto written = ros::write_robot(*writer, recording);
  ASSERT_TRUE(written) << written.error().to_string();
  ASSERT_TRUE(writer->close());
}
//! [write]

}  // namespace wayfare::testing
