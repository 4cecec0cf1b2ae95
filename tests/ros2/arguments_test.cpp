// The arguments of ROS 2 on a command line, and its names.

#include <string>
#include <utility>
#include <vector>

#include <wayfare/io/text_file.hpp>
#include "io/support.hpp"
#include "ros/dds/arguments.hpp"
#include "ros/dds/domain.hpp"
#include "ros/dds/names.hpp"

namespace wayfare::ros::dds {
namespace {

using ::testing::HasSubstr;
using Words = std::vector<std::string>;

TEST(Ros2Arguments, AreTakenFromBetweenTheOthers) {
  Words words = {"node",         "--map-period-s",    "2",          "--ros-args",
                 "-r",           "scan:=/front/scan", "-p",         "period:=2.0",
                 "--",           "--quiet",           "--ros-args", "--remap",
                 "__ns:=/robot", "--log-level",       "debug"};
  const auto taken = take_ros_arguments(words, "slam");
  ASSERT_TRUE(taken) << taken.error().to_string();
  EXPECT_EQ(words, (Words{"node", "--map-period-s", "2", "--quiet"}));
  EXPECT_EQ(taken->node.ns, "/robot");
  EXPECT_EQ(taken->parameter("period"), "2.0");
  EXPECT_EQ(taken->parameter("other"), "");
  EXPECT_EQ(*taken->topic("scan"), "/front/scan");
  EXPECT_EQ(*taken->topic("odom"), "/robot/odom");
  EXPECT_EQ(*taken->topic("~/map"), "/robot/slam/map");
  EXPECT_EQ(*taken->topic("/tf"), "/tf");
}

TEST(Ros2Arguments, ForAnotherNodeAreLeft) {
  Words words = {"node", "--ros-args",     "-r", "other:scan:=/a",
                 "-p",   "slam:rate:='3'", "-p", "other:rate:=4"};
  const auto taken = take_ros_arguments(words, "slam");
  ASSERT_TRUE(taken);
  EXPECT_EQ(*taken->topic("scan"), "/scan");
  EXPECT_EQ(taken->parameter("rate"), "3");
}

TEST(Ros2Arguments, ParameterFilesAreReadForThisNode) {
  const wayfare::testing::TemporaryFolder folder;
  const std::string path = folder / "parameters.yaml";
  ASSERT_TRUE(io::write_file(path, R"(# of two nodes
/**:
  ros__parameters:
    use_sim_time: true
    period: 1.0
slam:
  ros__parameters:
    period: 2.0  # seconds
    laser: [0.1, 0, 0]
    frame: "map a"
    nested:
      depth: 3
other:
  ros__parameters:
    period: 9.0
)"));
  Words words = {"node", "--ros-args", "--params-file", path, "-p", "frame:=b"};
  const auto taken = take_ros_arguments(words, "slam");
  ASSERT_TRUE(taken) << taken.error().to_string();
  EXPECT_EQ(taken->parameter("use_sim_time"), "true");
  EXPECT_EQ(taken->parameter("period"), "2.0");
  EXPECT_EQ(taken->parameter("nested.depth"), "3");
  EXPECT_EQ(taken->parameter("frame"), "b");
  EXPECT_EQ(taken->parameter("laser"), "[0.1, 0, 0]");
}

TEST(Ros2Arguments, WrongOnesAreNamed) {
  const wayfare::testing::TemporaryFolder folder;
  const std::string path = folder / "list.yaml";
  ASSERT_TRUE(io::write_file(path, "slam:\n  ros__parameters:\n    map: {a: 1}\n"));
  const std::vector<std::pair<Words, std::string>> wrong = {
      {{"-r"}, "-r: needs a value"},
      {{"-r", "scan"}, "scan: is not NAME:=VALUE"},
      {{"-r", "scan:=2d"}, "2d: is no name of ROS 2"},
      {{"-r", "__ns:=/a b"}, "/a b: is no name of ROS 2"},
      {{"-r", "__node:=a/b"}, "a/b: is no name of a node"},
      {{"--speed", "2"}, "--speed: is no argument of ROS 2"},
      {{"--params-file", path}, "list.yaml:3: is not 'name: value' with a plain value"},
      {{"--params-file", "/nowhere.yaml"}, "/nowhere.yaml"}};
  for (const auto& [arguments, error] : wrong) {
    Words words = {"node", "--ros-args"};
    words.insert(words.end(), arguments.begin(), arguments.end());
    const auto taken = take_ros_arguments(words, "slam");
    ASSERT_FALSE(taken) << error;
    EXPECT_THAT(taken.error().to_string(), HasSubstr(error));
  }
}

TEST(Ros2Names, TypesAreThoseOfTheWire) {
  EXPECT_EQ(dds_type("sensor_msgs/LaserScan"), "sensor_msgs::msg::dds_::LaserScan_");
  EXPECT_EQ(ros1_type("sensor_msgs::msg::dds_::LaserScan_"), "sensor_msgs/LaserScan");
  EXPECT_EQ(ros1_type("a::srv::dds_::B_Request_"), "a/srv/B_Request");
  EXPECT_EQ(dds_type("a/srv/B_Request"), "a::srv::dds_::B_Request_");
  EXPECT_EQ(ros1_type("Plain"), "Plain");
  EXPECT_EQ(dds_type("Plain"), "Plain");
}

TEST(Ros2Domain, ComesFromTheEnvironment) {
  ::setenv("ROS_DOMAIN_ID", "42", 1);
  ::unsetenv("ROS_LOCALHOST_ONLY");
  ::unsetenv("ROS_AUTOMATIC_DISCOVERY_RANGE");
  EXPECT_EQ(reach_of({})->domain, 42U);
  EXPECT_FALSE(reach_of({})->network);
  EXPECT_TRUE(reach_of({7, true})->network);
  ::setenv("ROS_LOCALHOST_ONLY", "0", 1);
  EXPECT_TRUE(reach_of({})->network);
  ::setenv("ROS_LOCALHOST_ONLY", "1", 1);
  EXPECT_FALSE(reach_of({})->network);
  ::setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET", 1);
  EXPECT_TRUE(reach_of({})->network);
  for (const char* wrong : {"233", "-1", "a", "4x"}) {
    ::setenv("ROS_DOMAIN_ID", wrong, 1);
    EXPECT_FALSE(reach_of({})) << wrong;
  }
}

}  // namespace
}  // namespace wayfare::ros::dds
