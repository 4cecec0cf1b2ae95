#pragma once

// Nodes as processes of their own on the loopback address: of ROS 1, with a master of the test's
// own, or with ROS_VERSION=2 of ROS 2, in a domain of the test's own.

#include <signal.h>

#include <cstdlib>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <wayfare/ros/node.hpp>
#ifdef WAYFARE_ROS1
#include <wayfare/ros/ros1_node.hpp>
#endif
#ifdef WAYFARE_ROS2
#include <wayfare/ros/ros2_node.hpp>
#endif
#include "io/support.hpp"
#include "processes.hpp"

namespace wayfare::testing {

using Command = std::vector<std::string>;

/// The master, and the test as a node; roscpp allows one node per process.
class Live : public ::testing::Test {
 public:
  static bool is_ros2() {
    const char* version = std::getenv("ROS_VERSION");
    return version != nullptr && std::string(version) == "2";
  }
  static void SetUpTestSuite() {
    folder_ = std::make_unique<TemporaryFolder>();
    Command arguments = {"test"};
    std::unique_ptr<ros::RawNode> raw = is_ros2() ? join_ros2(arguments) : join_ros1(arguments);
    if (!raw) return;
    node_ = std::make_unique<ros::Node>(std::move(raw));
    connected_ = node_->raw().connect();
  }
  static void TearDownTestSuite() {
    node_.reset();
    if (master_) master_->end(SIGINT);
    master_.reset();
    folder_.reset();
  }
  void SetUp() override {
    if (!node_)
      GTEST_SKIP() << "needs roscore (Debian's python3-roslaunch and rosout), or Cyclone DDS";
    ASSERT_TRUE(connected_);  // a failure in SetUpTestSuite would count as a test skipped
  }

  static std::string path(const std::string& name) { return *folder_ / name; }
  static bool spin_until(double seconds, const std::function<bool()>& done) {
    return until(seconds, done, [] { node_->spin(0.02); });
  }
  /// Topics have the test's name, so that latched messages of other tests are not received.
  static std::string topic(const std::string& name) {
    std::string full = "/";
    full += ::testing::UnitTest::GetInstance()->current_test_info()->name();
    return full.append("/").append(name);
  }
  static Command in_its_own_topics(Command command) {
    if (is_ros2()) command.push_back("--ros-args");
    for (const char* name :
         {"scan", "odom", "map", "path", "pose", "tf", "tf_static", "radar", "radar_points", "imu",
          "magnetic_field", "amcl_pose", "particle_cloud", "initialpose"}) {
      if (is_ros2()) command.push_back("-r");
      command.push_back(std::string("/").append(name).append(":=").append(topic(name)));
    }
    return command;
  }
  /// Plays a recording at twenty times its speed, once every topic of `heard` has a subscriber.
  static Process play(const std::string& recording, const Command& heard,
                      const Command& options = {}) {
    Command command = {WAYFARE_PLAY_RECORDING, recording, "--speed", "20"};
    for (const std::string& topic : heard) command.insert(command.end(), {"--wait-for", topic});
    command.insert(command.end(), options.begin(), options.end());
    return Process(in_its_own_topics(command), path("player.txt"));
  }
  /// Messages received on a topic from now on.
  template <class M>
  static std::shared_ptr<std::vector<M>> listen(const std::string& name, const ros::Qos& qos = {}) {
    auto heard = std::make_shared<std::vector<M>>();
    node_->subscribe<M>(topic(name), qos, [heard](const M& m) { heard->push_back(m); });
    return heard;
  }

  /// None without a master.
  static std::unique_ptr<ros::RawNode> join_ros1([[maybe_unused]] Command& arguments) {
#ifdef WAYFARE_ROS1
    if (!is_installed("roscore")) return nullptr;
    const std::string port = std::to_string(free_port());
    ::setenv("ROS_MASTER_URI", ("http://127.0.0.1:" + port).c_str(), 1);
    ::setenv("ROS_IP", "127.0.0.1", 1);
    ::setenv("ROS_VERSION", "1", 1);
    ::unsetenv("ROS_HOSTNAME");
    ::setenv("ROS_HOME", folder_->path().c_str(), 1);
    ::setenv("ROS_LOG_DIR", (*folder_ / "logs").c_str(), 1);
    master_ = std::make_unique<Process>(Command{"roscore", "-p", port}, *folder_ / "roscore.txt");
    return ros::ros1_node(arguments, "wayfare_test");
#else
    return nullptr;
#endif
  }
  static std::unique_ptr<ros::RawNode> join_ros2([[maybe_unused]] Command& arguments) {
#ifdef WAYFARE_ROS2
    ::setenv("ROS_DOMAIN_ID", std::to_string(own_domain()).c_str(), 1);
    ::unsetenv("ROS_LOCALHOST_ONLY");
    ::unsetenv("ROS_AUTOMATIC_DISCOVERY_RANGE");
    auto node = ros::ros2_node(arguments, "wayfare_test");
    EXPECT_TRUE(node);
    return node ? *std::move(node) : nullptr;
#else
    return nullptr;
#endif
  }

  inline static std::unique_ptr<TemporaryFolder> folder_;
  inline static std::unique_ptr<Process> master_;
  inline static std::unique_ptr<ros::Node> node_;
  inline static bool connected_ = false;
};

}  // namespace wayfare::testing
