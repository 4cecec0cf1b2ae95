// A walker's devices through their nodes: bytes of a tracker to the Xsens driver, its samples and
// laser scans to pedestrian SLAM and Hector SLAM, against the programs on a recording of the
// topics.

#include <signal.h>

#include <atomic>
#include <cmath>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include <wayfare/io/text_file.hpp>
#include <wayfare/logger/device_decoder.hpp>
#include <wayfare/ros/convert.hpp>
#include <wayfare/ros/recording.hpp>
#include "awinda_bytes.hpp"
#include "head_walk.hpp"
#include "live.hpp"

namespace wayfare {
namespace {

using testing::AwindaTracker;
using testing::Command;
using ::testing::HasSubstr;
using testing::head_walk;
using testing::HeadWalk;
using testing::Live;
using testing::Process;

/// Plays bytes into a pseudo-terminal at their times, in a thread.
class Device {
 public:
  explicit Device(logger::PseudoTerminal& terminal, std::vector<logger::TimedBytes> stream)
      : stream_(std::move(stream)),
        thread_([&] { EXPECT_TRUE(logger::play(terminal, stream_, 1.0, stop_)); }) {}
  ~Device() {
    stop_ = true;
    thread_.join();
  }

 private:
  std::vector<logger::TimedBytes> stream_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

bool says(const Process& process, const std::string& text) {
  return Live::spin_until(30.0, [&] { return process.output().find(text) != std::string::npos; });
}

struct XYAtTime {
  double t, x, y;
};
/// The positions of a TUM file.
std::vector<XYAtTime> positions(const std::string& path) {
  std::vector<XYAtTime> all;
  std::istringstream lines(io::read_file(path).value().bytes);
  for (std::string line; std::getline(lines, line);) {
    XYAtTime p{};
    if (line.starts_with("#")) continue;
    std::istringstream(line) >> p.t >> p.x >> p.y;
    all.push_back(p);
  }
  return all;
}

/// The last path against a program on the recording: that prints 1e-6 m, and stamps are those of
/// the messages.
void expect_offline(const ros::Path& live, const Command& program) {
  Process offline(program, Live::path("offline.txt"));
  ASSERT_EQ(offline.wait(120.0), 0) << offline.output();
  const auto expected = positions(Live::path("offline/trajectory.tum"));
  ASSERT_EQ(live.poses.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_NEAR(ros::time_of(live.poses[i].header.stamp)->seconds(), expected[i].t, 1e-6) << i;
    EXPECT_NEAR(live.poses[i].pose.position.x, expected[i].x, 1e-6) << i;
    EXPECT_NEAR(live.poses[i].pose.position.y, expected[i].y, 1e-6) << i;
  }
}

// Four seconds at rest, 11 m through two rooms, four seconds at rest.
TEST_F(Live, AWalkThroughDriverAndNodesGivesTheOfflineTrajectories) {
  auto terminal = logger::PseudoTerminal::open();
  ASSERT_TRUE(terminal);
  Process driver(in_its_own_topics({WAYFARE_XSENS_DRIVER, "--port", terminal->path()}),
                 path("xsens_driver.txt"));
  const Command mounting = {"--forward", "x", "--settle-s", "4", "--laser", "0", "0", "0"};
  const Command steps = {"--length", "constant", "--factor", "0.66"};
  Command walker = {WAYFARE_PEDESTRIAN_SLAM_NODE}, hector = {WAYFARE_HECTOR_NODE, "--imu"};
  for (Command* command : {&walker, &hector})
    command->insert(command->end(), mounting.begin(), mounting.end());
  walker.insert(walker.end(), steps.begin(), steps.end());
  Process slam(in_its_own_topics(walker), path("pedestrian_slam_node.txt"));
  Command apart = in_its_own_topics(hector);
  for (std::string& word : apart)
    if (word.starts_with("/path:=") || word.starts_with("/pose:=")) word += "_hector";
  Process second(apart, path("hector_node.txt"));

  const auto samples = listen<ros::Imu>("imu");
  const auto fields = listen<ros::MagneticField>("magnetic_field");
  const auto paths = listen<ros::Path>("path"), others = listen<ros::Path>("path_hector");
  auto scans = node_->publisher<ros::LaserScan>(topic("scan"));
  ASSERT_TRUE(says(driver, "reading " + terminal->path())) << driver.output();
  ASSERT_TRUE(says(driver, "no bytes from " + terminal->path())) << driver.output();
  ASSERT_TRUE(says(slam, "waits for laser scans")) << slam.output();
  ASSERT_TRUE(says(second, "waits for laser scans")) << second.output();
  ASSERT_TRUE(spin_until(30.0, [&] { return scans.subscribers() == 2; }));

  const LogTime begin = LogTime::from_nanoseconds(node_->now_ns());
  const HeadWalk walk = head_walk(begin);
  decode::Stream bytes = testing::awinda_configuration();
  std::vector<std::size_t> ends;
  AwindaTracker tracker;
  for (const MargSample& s : walk.unit) {
    decode::append(bytes, tracker.next(s));
    ends.push_back(bytes.size());
  }
  std::vector<logger::TimedBytes> stream;
  for (std::size_t i = 0; i < ends.size(); ++i) {
    const std::size_t from = i == 0 ? 0 : ends[i - 1];
    stream.push_back(
        {walk.unit[i].time - begin, decode::Bytes(bytes).subspan(from, ends[i] - from)});
  }
  const Device device(*terminal, stream);
  auto writer = ros::RecordingWriter::create(path("walker.bag"));
  ASSERT_TRUE(writer);
  for (const LaserScan& scan : walk.log.scans) {
    spin_until(30.0, [&] { return node_->now_ns() >= scan.time.nanoseconds(); });
    scans.publish(ros::message_of(scan, "laser"));
    ASSERT_TRUE(writer->write("/scan", scan.time, ros::message_of(scan, "laser")));
  }
  const std::size_t n = walk.log.scans.size();
  const auto complete = [n](const auto& heard) {
    return !heard->empty() && heard->back().poses.size() == n;
  };
  ASSERT_TRUE(spin_until(60.0, [&] { return complete(paths) && complete(others); }))
      << slam.output() << second.output();
  // Until the graph is optimised: the last path that is published.
  std::size_t heard = 0;
  spin_until(60.0, [&] {
    if (heard == paths->size()) return true;
    heard = paths->size();
    spin_until(6.0, [] { return false; });
    return false;
  });

  ASSERT_GE(samples->size() + 1, walk.unit.size()) << driver.output();
  EXPECT_EQ(fields->size(), samples->size());
  for (const ros::Imu& m : *samples)
    ASSERT_TRUE(writer->write("/imu", *ros::time_of(m.header.stamp), m));
  ASSERT_TRUE(writer->close());
  const Command common = {path("walker.bag"), "--forward", "x",      "--out",
                          path("offline"),    "--force",   "--quiet"};
  Command program = {WAYFARE_PEDESTRIAN_SLAM};
  program.insert(program.end(), common.begin(), common.end());
  program.insert(program.end(), steps.begin(), steps.end());
  expect_offline(paths->back(), program);
  program = {WAYFARE_HECTOR_SLAM};
  program.insert(program.end(), common.begin(), common.end());
  expect_offline(others->back(), program);
  // As the simulated walk: samples are mapped to the time of the scans to a few milliseconds, of a
  // walker at 1.2 m/s; noise is 1 to 5 cm.
  const auto& end = paths->back().poses.back().pose.position;
  EXPECT_NEAR(std::hypot(end.x, end.y), (walk.truth_m.back() - walk.truth_m.front()).norm(), 0.2);
  for (const Process* node : {&slam, &second})
    EXPECT_EQ(node->output().find("no inertial samples"), std::string::npos) << node->output();
  EXPECT_EQ(driver.end(SIGTERM), 0);
  EXPECT_THAT(driver.output(), HasSubstr("publishes tracker 00B42A11"));
  EXPECT_EQ(slam.end(SIGTERM), 0);
  EXPECT_EQ(second.end(SIGTERM), 0);
}

TEST_F(Live, TheXsensDriverNamesGarbageAndOtherTrackers) {
  auto terminal = logger::PseudoTerminal::open();
  ASSERT_TRUE(terminal);
  Process refused(
      in_its_own_topics({WAYFARE_XSENS_DRIVER, "--port", terminal->path(), "--tracker", "12"}),
      path("refused_tracker.txt"));
  EXPECT_EQ(refused.wait(60.0), 1);
  EXPECT_THAT(refused.output(), HasSubstr("--tracker must be eight hexadecimal digits, not 12"));
  Process driver(in_its_own_topics(
                     {WAYFARE_XSENS_DRIVER, "--port", terminal->path(), "--tracker", "00b42a12"}),
                 path("chosen_tracker.txt"));
  const auto samples = listen<ros::Imu>("imu");
  ASSERT_TRUE(says(driver, "reading " + terminal->path())) << driver.output();
  ASSERT_TRUE(says(driver, "no bytes from ")) << driver.output();
  // As of a line at another rate.
  decode::Stream noise;
  Rng rng(3);
  for (int i = 0; i < 20'000; ++i) noise.push_back(static_cast<std::uint8_t>(rng.below(256)));
  {
    const Device device(*terminal, logger::at_rate(noise, 4000.0));
    EXPECT_TRUE(says(driver, "without a message: another --baud, or another device?"))
        << driver.output();
  }
  EXPECT_TRUE(samples->empty());
  decode::Stream bytes;
  AwindaTracker first, second(testing::kTracker + 1);
  for (int i = 0; i < 300; ++i) {
    const MargSample still{LogTime(), Eigen::Vector3d::Zero(), Eigen::Vector3d(0.0, 0.0, 9.81)};
    decode::append(bytes, first.next(still));
    decode::append(bytes, second.next(still));
  }
  const Device device(*terminal, logger::at_rate(bytes, 12'000.0));
  EXPECT_TRUE(says(driver, "left out tracker 00B42A11: publishes 00B42A12")) << driver.output();
  EXPECT_TRUE(spin_until(30.0, [&] { return samples->size() >= 250; })) << driver.output();
  EXPECT_NEAR(samples->back().linear_acceleration.z, 9.81, 2e-3);  // 2^-16 m/s over 10 ms
  EXPECT_EQ(driver.end(SIGTERM), 0);
}

// Devices and topics that are not there, and calibrations that are none, end the node or are named.
TEST_F(Live, TheWalkersNodesNameWhatIsMissing) {
  ASSERT_TRUE(io::write_file(path("empty.json"), "{}", {io::Existing::replace}));
  Process refused(
      in_its_own_topics({WAYFARE_PEDESTRIAN_SLAM_NODE, "--calibration", path("empty.json")}),
      path("refused_walker.txt"));
  EXPECT_EQ(refused.wait(60.0), 1);
  EXPECT_THAT(refused.output(), HasSubstr("empty.json: needs 'length'"));
  Process walker(in_its_own_topics({WAYFARE_PEDESTRIAN_SLAM_NODE, "--laser", "0", "0", "0",
                                    "--length", "constant", "--factor", "0.7"}),
                 path("alone.txt"));
  auto scans = node_->publisher<ros::LaserScan>(topic("scan"));
  EXPECT_TRUE(says(walker, "waits for laser scans")) << walker.output();
  scans.publish(
      ros::message_of(head_walk(LogTime::from_seconds(1000.0)).log.scans.front(), "laser"));
  EXPECT_TRUE(says(walker, "waits for inertial samples")) << walker.output();
  EXPECT_THAT(walker.output(), HasSubstr("a replay, or clocks that differ"));
  EXPECT_EQ(walker.end(SIGTERM), 0);
  Process driver(in_its_own_topics({WAYFARE_XSENS_DRIVER, "--port", "/dev/nowhere"}),
                 path("no_port.txt"));
  EXPECT_TRUE(says(driver, "waiting for the device: /dev/nowhere")) << driver.output();
  EXPECT_EQ(driver.end(SIGTERM), 0);
}

}  // namespace
}  // namespace wayfare
