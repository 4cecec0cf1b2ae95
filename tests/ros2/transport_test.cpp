// Messages between nodes of ROS 2 on Cyclone DDS: quality of service, names, time, discovery.

#include <netinet/in.h>
#include <sys/socket.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "ros2/own_domain.hpp"

namespace wayfare {
namespace {

using testing::own_node;
using testing::spin_until;

ros::LaserScan numbered_scan(std::uint32_t number) {
  ros::LaserScan scan;
  scan.header.stamp = {1000, number};
  scan.header.frame_id = "laser";
  scan.angle_increment = 0.01F;
  scan.range_max = 30.0F;
  scan.ranges.assign(1080, 1.0F + static_cast<float>(number));
  return scan;
}

/// The numbers of the scans that a node receives.
struct ScanNumbers {
  ScanNumbers(ros::Node& node, const std::string& topic, const ros::Qos& qos = {}) {
    node.subscribe<ros::LaserScan>(topic, qos, [this](const ros::LaserScan& scan) {
      all.push_back(scan.header.stamp.nanosec);
      last = scan;
    });
  }
  std::vector<std::uint32_t> all;
  ros::LaserScan last;
};

TEST(Ros2Transport, ScansArriveInOrderAndUnchanged) {
  const auto sender = own_node("sender"), receiver = own_node("receiver");
  auto scans = sender->publisher<ros::LaserScan>("scan");
  ScanNumbers heard(*receiver, "scan");
  ASSERT_TRUE(spin_until({receiver.get()}, [&] { return scans.subscribers() == 1; }));
  for (std::uint32_t i = 0; i < 100; ++i) scans.publish(numbered_scan(i));
  ASSERT_TRUE(spin_until({receiver.get()}, [&] { return heard.all.size() >= 100; }));
  for (std::uint32_t i = 0; i < 100; ++i) EXPECT_EQ(heard.all[i], i);
  EXPECT_EQ(ros::to_cdr(heard.last), ros::to_cdr(numbered_scan(99)));
  const auto counts = receiver->counts();
  ASSERT_EQ(counts.size(), 1U);
  EXPECT_EQ(counts[0].topic, "/scan");
  EXPECT_EQ(counts[0].received, 100U);
  EXPECT_EQ(counts[0].refused + counts[0].lost, 0U);
}

TEST(Ros2Transport, ALateSubscriberGetsTheLatchedMessage) {
  const auto sender = own_node("sender");
  auto map = sender->publisher<ros::OccupancyGrid>("map", ros::Qos::latched());
  ros::OccupancyGrid grid;
  grid.info.width = 1000, grid.info.height = 700;
  grid.data.assign(700'000, 0);
  map.publish(grid);
  grid.data[5] = 100;
  map.publish(grid);
  const auto late = own_node("late");
  std::vector<ros::OccupancyGrid> heard;
  late->subscribe<ros::OccupancyGrid>("map", ros::Qos::latched(),
                                      [&](const auto& m) { heard.push_back(m); });
  ASSERT_TRUE(spin_until({late.get()}, [&] { return !heard.empty(); }));
  late->spin(0.1);
  ASSERT_EQ(heard.size(), 1U);
  EXPECT_EQ(heard[0].data, grid.data);
}

// A subscriber asks for all it can get: a sensor's best effort, and static transforms of a
// publisher that keeps none, are received all the same.
TEST(Ros2Transport, ASubscriberTakesWhatAPublisherOffers) {
  const auto sender = own_node("sender"), receiver = own_node("receiver");
  auto scans = sender->publisher<ros::LaserScan>("scan", ros::Qos::sensor_data());
  auto transforms = sender->publisher<ros::TfMessage>("tf_static", ros::Qos::queue(10));
  ScanNumbers heard(*receiver, "scan");
  std::size_t mountings = 0;
  ::testing::internal::CaptureStderr();
  receiver->subscribe<ros::TfMessage>("tf_static", ros::Qos::latched(10),
                                      [&](const auto&) { ++mountings; });
  std::uint32_t sent = 0;
  EXPECT_TRUE(spin_until({receiver.get()}, [&] {
    scans.publish(numbered_scan(sent++));
    transforms.publish({});
    return heard.all.size() >= 3 && mountings >= 3;
  }));
  const std::string said = ::testing::internal::GetCapturedStderr();
  EXPECT_THAT(said, ::testing::HasSubstr("'/scan' offers best effort"));
  EXPECT_THAT(said, ::testing::HasSubstr("'/tf_static' keeps no messages"));
}

// A second publisher that offers less costs nothing with the first.
TEST(Ros2Transport, APublisherThatOffersLessIsReceivedBesidesOthers) {
  const auto sender = own_node("sender"), receiver = own_node("receiver");
  auto kept = sender->publisher<ros::LaserScan>("scan", ros::Qos::latched(100));
  auto lossy = sender->publisher<ros::LaserScan>("scan", ros::Qos::sensor_data(100));
  for (std::uint32_t i = 0; i < 50; ++i) kept.publish(numbered_scan(i));
  ScanNumbers heard(*receiver, "scan", ros::Qos::latched(1000));
  ASSERT_TRUE(spin_until({receiver.get()},
                         [&] { return heard.all.size() >= 50 && lossy.subscribers() == 1; }));
  for (std::uint32_t i = 50; i < 100; ++i) kept.publish(numbered_scan(i));
  for (std::uint32_t i = 100; i < 150; ++i) lossy.publish(numbered_scan(i));
  ASSERT_TRUE(spin_until({receiver.get()}, [&] { return heard.all.size() >= 150; }));
  receiver->spin(0.1);
  ASSERT_EQ(heard.all.size(), 150U);
  for (std::uint32_t i = 0; i < 150; ++i) EXPECT_EQ(heard.all[i], i);
}

TEST(Ros2Transport, WhatAFullQueueDropsIsCounted) {
  const auto sender = own_node("sender"), receiver = own_node("receiver");
  auto scans = sender->publisher<ros::LaserScan>("scan");
  ScanNumbers heard(*receiver, "scan", ros::Qos::queue(5));
  ASSERT_TRUE(spin_until({receiver.get()}, [&] { return scans.subscribers() == 1; }));
  for (std::uint32_t i = 0; i < 50; ++i) scans.publish(numbered_scan(i));
  ASSERT_TRUE(
      spin_until({receiver.get()}, [&] { return !heard.all.empty() && heard.all.back() == 49; }));
  const auto counts = receiver->counts();
  EXPECT_EQ(counts[0].received, heard.all.size());
  EXPECT_EQ(counts[0].received + counts[0].lost, 50U);
  EXPECT_GE(counts[0].lost, 40U);
}

TEST(Ros2Transport, NamesFollowNamespacesAndRemappings) {
  const auto robot = own_node("mapper", {"--ros-args", "-r", "__ns:=/robot", "-r",
                                         "scan:=/front/scan", "-r", "__node:=slam"});
  const auto other = own_node("other");
  auto scans = other->publisher<ros::LaserScan>("/front/scan");
  ScanNumbers heard(*robot, "scan");
  auto map = robot->publisher<ros::OccupancyGrid>("map", ros::Qos::latched());
  auto own = robot->publisher<ros::String>("~/state", ros::Qos::latched());
  ASSERT_TRUE(spin_until({robot.get(), other.get()}, [&] {
    scans.publish(numbered_scan(1));
    return !heard.all.empty() && other->raw().topics().size() >= 2;
  }));
  std::vector<std::string> names;
  for (const auto& topic : other->raw().topics()) names.push_back(topic.name + " " + topic.type);
  EXPECT_THAT(names, ::testing::UnorderedElementsAre("/robot/map nav_msgs/OccupancyGrid",
                                                     "/robot/slam/state std_msgs/String"));
  for (const auto& topic : other->raw().topics()) {
    EXPECT_EQ(topic.type_hash, ros::type_hash(topic.type));
    EXPECT_EQ(topic.qos.durability, ros::Durability::transient_local);
  }
}

TEST(Ros2Transport, SimulatedTimeIsThatOfTheClockTopic) {
  const auto simulator = own_node("simulator");
  const auto node = own_node("node", {"--ros-args", "-p", "use_sim_time:=true", "-p", "rate:=2.5"});
  EXPECT_EQ(node->now_ns(), 0);
  EXPECT_GT(simulator->now_ns(), 1'000'000'000'000'000'000);
  const std::vector<std::pair<std::string, std::string>> own = {{"rate", "2.5"}};
  EXPECT_EQ(node->raw().parameters(), own);
  auto clock = simulator->publisher<ros::Clock>("/clock");
  ASSERT_TRUE(spin_until({node.get()}, [&] {
    clock.publish({{1234, 500}});
    return node->now_ns() != 0;
  }));
  EXPECT_EQ(node->now_ns(), 1'234'000'000'500);
}

/// UDP sockets of this process that receive from all addresses.
std::size_t open_sockets() {
  std::size_t n = 0;
  for (int fd = 0; fd < 256; ++fd) {
    sockaddr_in address{};
    socklen_t size = sizeof address;
    if (::getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size) != 0 ||
        address.sin_family != AF_INET || address.sin_addr.s_addr != htonl(INADDR_ANY))
      continue;
    char device[16] = {};
    size = sizeof device;
    ::getsockopt(fd, SOL_SOCKET, SO_BINDTODEVICE, device, &size);
    if (std::string(device) != "lo") ++n;
  }
  return n;
}

TEST(Ros2Transport, ListensOnTheLoopbackDeviceOnly) {
  const auto node = own_node("alone"), second = own_node("second");
  EXPECT_EQ(open_sockets(), 0U);
}

TEST(Ros2Transport, AMissingPublisherEndsTheTopicNotTheSubscriber) {
  const auto receiver = own_node("receiver");
  ScanNumbers heard(*receiver, "scan");
  for (std::uint32_t life = 0; life < 2; ++life) {
    const auto sender = own_node("sender");
    auto scans = sender->publisher<ros::LaserScan>("scan");
    ASSERT_TRUE(spin_until({receiver.get()}, [&] {
      scans.publish(numbered_scan(life));
      return !heard.all.empty() && heard.all.back() == life;
    }));
  }
  EXPECT_TRUE(spin_until({receiver.get()}, [&] { return receiver->raw().topics().empty(); }));
}

}  // namespace
}  // namespace wayfare
