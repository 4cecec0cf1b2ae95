// Devices on pseudo-terminals through the driver nodes: every frame once, unchanged.

#include <signal.h>

#include <atomic>
#include <string>
#include <vector>

#include <wayfare/decode/rplidar_stream.hpp>
#include <wayfare/decode/rplidar_sweep.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/logger/device_decoder.hpp>
#include <wayfare/ros/convert.hpp>
#include "decode/rplidar_streams.hpp"
#include "decode/ti_streams.hpp"
#include "live.hpp"

namespace wayfare {
namespace {

using testing::Command;
using ::testing::HasSubstr;
using testing::Live;
using testing::Process;

/// A real capture, or if absent one built according to the format.
decode::Stream capture(const std::string& name, const decode::Stream& built) {
  const std::string path = testing::recording(name);
  if (path.empty()) return built;
  const std::string bytes = io::read_file(path)->bytes;
  return {bytes.begin(), bytes.end()};
}

decode::Stream radar_frames() {
  decode::Stream all;
  for (std::uint32_t i = 1; i <= 60; ++i)
    decode::append(all, decode::frame(i, i % 5,
                                      {decode::float_points(static_cast<int>(i % 5)),
                                       decode::side_info(static_cast<int>(i % 5))}));
  return all;
}

decode::Stream lidar_turns() {
  decode::Stream all = decode::descriptor(decode::RplidarResponse::node, 5, true);
  for (int i = 0; i < 30 * 90; ++i)
    decode::append(all, decode::node(i % 90 * 256, 4000 + 16 * (i / 90), 15, i % 90 == 0));
  return all;
}

/// Plays the bytes to a driver with a subscriber; returns the driver's last output.
template <class Heard>
std::string drive(const std::string& program, const decode::Stream& bytes, const Heard& heard,
                  std::size_t messages) {
  auto terminal = logger::PseudoTerminal::open();
  Process driver(Live::in_its_own_topics({program, "--port", terminal->path()}),
                 Live::path("driver.txt"));
  EXPECT_TRUE(Live::spin_until(30.0, [&] {
    return driver.output().find("reading " + terminal->path()) != std::string::npos;
  })) << driver.output();
  Live::spin_until(1.0, [] { return false; });  // until the topic is connected
  const std::atomic<bool> stop{false};
  EXPECT_TRUE(logger::play(*terminal, logger::at_rate(bytes, 500'000.0), 1.0, stop));
  EXPECT_TRUE(Live::spin_until(30.0, [&] { return heard->size() >= messages; }))
      << heard->size() << " of " << messages << " messages\n"
      << driver.output();
  Live::spin_until(0.5, [] { return false; });  // none is duplicated
  EXPECT_EQ(driver.end(SIGTERM), 0);
  return driver.output();
}

TEST_F(Live, EveryFrameOfARadarArrivesOnce) {
  const auto bytes = capture("devices/ti_mmwave/awr1843_sdk3.6/mer1.dat.gz", radar_frames());
  std::vector<RadarScan> frames;
  logger::TiStream stream(921600);
  stream.feed(bytes, LogTime(), [&](const RadarScan& scan) { frames.push_back(scan); });
  ASSERT_GE(frames.size(), 60U);
  const auto heard = listen<ros::RadarScan>("radar");
  const auto clouds = listen<ros::PointCloud2>("radar_points");
  const std::string said = drive(WAYFARE_RADAR_DRIVER, bytes, heard, frames.size());
  EXPECT_THAT(said, HasSubstr(std::to_string(frames.size()) + " messages"));
  ASSERT_EQ(heard->size(), frames.size());
  EXPECT_EQ(clouds->size(), frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const ros::RadarScan& m = (*heard)[i];
    EXPECT_EQ(m.header.frame_id, "radar");
    EXPECT_EQ(ros::radar_scan_of(m, LogTime())->points, frames[i].points) << i;
    // Relative to this computer's clock; within a minute only, since frames arrive faster than at
    // the rate of the radar's own clock, by which they are stamped.
    const LogTime now = LogTime::from_nanoseconds(node_->now_ns());
    EXPECT_TRUE(ros::check_clock(*ros::time_of(m.header.stamp), now, from_seconds(60.0)));
  }
}

TEST_F(Live, EveryRevolutionOfALidarArrivesOnce) {
  const auto bytes = capture("devices/rplidar/legacy_scan_bin/living_room_116_steps/frame_0008.bin",
                             lidar_turns());
  std::vector<LaserScan> turns;
  decode::RplidarStream stream(115200);
  stream.feed(bytes, LogTime(), [&](const decode::RplidarRevolution& turn) {
    turns.push_back(decode::to_laser_sweep(turn));
  });
  ASSERT_GE(turns.size(), 1U);
  const auto heard = listen<ros::LaserScan>("scan");
  const std::string said = drive(WAYFARE_LIDAR_DRIVER, bytes, heard, turns.size());
  EXPECT_THAT(said, HasSubstr(std::to_string(turns.size()) + " messages"));
  ASSERT_EQ(heard->size(), turns.size());
  for (std::size_t i = 0; i < turns.size(); ++i) {
    const auto scan = ros::laser_scan_of((*heard)[i], LogTime());
    ASSERT_TRUE(scan);
    ASSERT_EQ(scan->ranges_m.size(), turns[i].ranges_m.size());
    for (std::size_t beam = 0; beam < scan->ranges_m.size(); ++beam) {
      ASSERT_EQ(scan->returned(beam), turns[i].returned(beam)) << i << ", " << beam;
      if (scan->returned(beam)) {
        ASSERT_EQ(scan->ranges_m[beam], turns[i].ranges_m[beam]) << i << ", " << beam;
      }
    }
  }
}

}  // namespace
}  // namespace wayfare
