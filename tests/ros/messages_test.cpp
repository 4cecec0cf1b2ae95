// ROS messages as bytes: compared with bytes worked out by hand, round trips, truncation.

#include <wayfare/ros/serialise.hpp>

#include <wayfare/ros/message_parts.hpp>
#include <wayfare/ros/messages.hpp>

#include <gmock/gmock.h>

#include "sample_messages.hpp"

namespace wayfare::ros {
namespace {

using ::testing::HasSubstr;
using ::wayfare::testing::for_each_message;

std::string bytes(std::initializer_list<int> values) {
  std::string out;
  for (const int v : values) out += static_cast<char>(v);
  return out;
}

PoseStamped pose() {
  PoseStamped m;
  m.header = {7, {1, 2}, "map"};
  m.pose.position.x = 1.0;      // 0x3ff0000000000000
  m.pose.orientation.w = -2.0;  // 0xc000000000000000
  return m;
}

TEST(Messages, Ros1IsPackedAndLittleEndian) {
  // seq, sec, nsec, length and text without terminator, then seven doubles.
  const std::string expected = bytes({7, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 3, 0, 0, 0}) + "map" +
                               bytes({0, 0, 0, 0, 0, 0, 0xf0, 0x3f}) + std::string(5 * 8, '\0') +
                               bytes({0, 0, 0, 0, 0, 0, 0, 0xc0});
  EXPECT_EQ(to_ros1(pose()), expected);
}

TEST(Messages, CdrAlignsEveryNumberToItsSize) {
  // Four bytes of encoding; sec, nsec (no seq), a text with its counted terminator: 16 bytes, so
  // the doubles are aligned to eight already.
  const std::string tail = std::string(5 * 8, '\0');
  EXPECT_EQ(to_cdr(pose()), bytes({0, 1, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 4, 0, 0, 0}) +
                                std::string("map\0", 4) + bytes({0, 0, 0, 0, 0, 0, 0xf0, 0x3f}) +
                                tail + bytes({0, 0, 0, 0, 0, 0, 0, 0xc0}));
  EXPECT_EQ(to_cdr(pose(), ByteOrder::big),
            bytes({0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 4}) + std::string("map\0", 4) +
                bytes({0x3f, 0xf0, 0, 0, 0, 0, 0, 0}) + tail + bytes({0xc0, 0, 0, 0, 0, 0, 0, 0}));
  // One letter more: 17 bytes, and seven of padding.
  PoseStamped longer = pose();
  longer.header.frame_id = "maps";
  EXPECT_EQ(to_cdr(longer).substr(4 + 12, 5 + 7 + 8),
            std::string("maps\0\0\0\0\0\0\0\0", 12) + bytes({0, 0, 0, 0, 0, 0, 0xf0, 0x3f}));
}

TEST(Messages, ParticlesAreAlignedAfterTheirNumber) {
  ParticleCloud cloud;
  cloud.header = {0, {1, 2}, "map"};
  cloud.particles.resize(2);
  cloud.particles[1].pose.position.y = 1.0;
  cloud.particles[1].weight = -2.0;
  const std::string zeros(8, '\0'), one = bytes({0, 0, 0, 0, 0, 0, 0xf0, 0x3f});
  const std::string minus_two = bytes({0, 0, 0, 0, 0, 0, 0, 0xc0});
  std::string poses;
  for (int i = 0; i < 9; ++i) poses += zeros;
  poses += one;
  for (int i = 0; i < 5; ++i) poses += zeros;
  poses += minus_two;
  // Stamp and text are 16 bytes; the number of particles is four, followed by four of padding.
  EXPECT_EQ(to_cdr(cloud), bytes({0, 1, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 4, 0, 0, 0}) +
                               std::string("map\0", 4) + bytes({2, 0, 0, 0, 0, 0, 0, 0}) + poses);
  EXPECT_EQ(to_cdr(Clock{{1, 2}}), bytes({0, 1, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0}));
  EXPECT_EQ(definition<Clock>(Dialect::ros1), "time clock\n");
  EXPECT_THAT(definition<ParticleCloud>(Dialect::ros2),
              HasSubstr("nav2_msgs/Particle[] particles\n"));
}

TEST(Messages, CdrOfTheSecondVersionAlignsToFourBytes) {
  std::string cdr2 = bytes({0, 7, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 5, 0, 0, 0}) +
                     std::string("maps\0\0\0\0", 8) + bytes({0, 0, 0, 0, 0, 0, 0xf0, 0x3f}) +
                     std::string(6 * 8, '\0');
  const auto read = from_cdr<PoseStamped>(cdr2);
  ASSERT_TRUE(read) << read.error().to_string();
  EXPECT_EQ(read->header.frame_id, "maps");
  EXPECT_EQ(read->pose.position.x, 1.0);
}

TEST(Messages, AllRoundTrip) {
  for_each_message([](const auto& message) {
    using M = std::decay_t<decltype(message)>;
    SCOPED_TRACE(M::kType.name);
    const std::string packed = to_ros1(message);
    const auto back = from_ros1<M>(packed);
    ASSERT_TRUE(back) << back.error().to_string();
    EXPECT_EQ(to_ros1(*back), packed);
    for (const ByteOrder order : {ByteOrder::little, ByteOrder::big}) {
      const std::string cdr = to_cdr(message, order);
      const auto again = from_cdr<M>(cdr);
      ASSERT_TRUE(again) << again.error().to_string();
      EXPECT_EQ(to_cdr(*again, order), cdr);
      if (std::is_same_v<M, TfMessage>) continue;  // nested headers: no seq in CDR
      auto plain = *back;
      if constexpr (requires { plain.header; }) {
        plain.header.seq = 0;
        EXPECT_EQ(to_ros1(plain).substr(4, 8), to_ros1(*again).substr(4, 8));
      }
    }
  });
}

TEST(Messages, TruncationIsAnError) {
  for_each_message([](const auto& message) {
    using M = std::decay_t<decltype(message)>;
    SCOPED_TRACE(M::kType.name);
    const std::string packed = to_ros1(message), cdr = to_cdr(message);
    for (std::size_t n = 0; n < packed.size(); ++n) EXPECT_FALSE(from_ros1<M>(packed.substr(0, n)));
    for (std::size_t n = 0; n < cdr.size(); ++n) EXPECT_FALSE(from_cdr<M>(cdr.substr(0, n)));
    EXPECT_FALSE(from_ros1<M>(packed + "x"));
    EXPECT_TRUE(from_cdr<M>(cdr + std::string(3, '\0')));  // padding added by some senders
    EXPECT_FALSE(from_cdr<M>(cdr + std::string(8, '\0')));
  });
}

TEST(Messages, ExcessiveLengthsAreRefusedBeforeAllocation) {
  // 4294967295 transforms, ranges and letters in a few bytes.
  EXPECT_FALSE(from_ros1<TfMessage>(bytes({255, 255, 255, 255, 0, 0})));
  std::string scan = to_ros1(LaserScan{});
  scan.replace(scan.size() - 8, 4, "\xff\xff\xff\xff");
  const auto read = from_ros1<LaserScan>(scan);
  ASSERT_FALSE(read);
  EXPECT_THAT(read.error().to_string(), HasSubstr("LaserScan: ends within its field ranges"));
  EXPECT_FALSE(from_ros1<Header>(std::string(12, '\0') + bytes({255, 255, 255, 255})));
}

TEST(Messages, OtherEncodingsAreNamed) {
  const auto parameters = from_cdr<Header>(bytes({0, 3, 0, 0}));
  ASSERT_FALSE(parameters);
  EXPECT_EQ(parameters.error().code, ErrorCode::unsupported);
  EXPECT_THAT(parameters.error().to_string(), HasSubstr("CDR kind 3"));
  EXPECT_FALSE(from_cdr<Header>("ab"));
  // A text without terminator.
  EXPECT_FALSE(from_cdr<Header>(bytes({0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 'a'})));
}

TEST(Messages, DefinitionsNameTheirFields) {
  EXPECT_EQ(definition<Header>(Dialect::ros1), "uint32 seq\ntime stamp\nstring frame_id\n");
  const std::string line = std::string(80, '=') + "\n";
  EXPECT_EQ(definition<TfMessage>(Dialect::ros2),
            "geometry_msgs/TransformStamped[] transforms\n" + line +
                "MSG: geometry_msgs/TransformStamped\nstd_msgs/Header header\n"
                "string child_frame_id\ngeometry_msgs/Transform transform\n" +
                line + "MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n" +
                line + "MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n" + line +
                "MSG: geometry_msgs/Transform\ngeometry_msgs/Vector3 translation\n"
                "geometry_msgs/Quaternion rotation\n" +
                line + "MSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n" + line +
                "MSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n");
  EXPECT_THAT(definition<OccupancyGrid>(Dialect::ros1),
              HasSubstr("time map_load_time\nfloat32 resolution\nuint32 width\n"));
  EXPECT_THAT(definition<PointCloud2>(Dialect::ros1), HasSubstr("PointField[] fields\nbool is_b"));
}

TEST(Messages, NamesOfBothGenerations) {
  EXPECT_EQ(ros2_name("sensor_msgs/Imu"), "sensor_msgs/msg/Imu");
  EXPECT_EQ(ros1_name("sensor_msgs/msg/Imu"), "sensor_msgs/Imu");
  for (const char* name : {"Imu", "sensor_msgs/msg/Imu"}) EXPECT_EQ(ros2_name(name), name);
  EXPECT_EQ(ros1_name("sensor_msgs/Imu"), "sensor_msgs/Imu");
}

}  // namespace
}  // namespace wayfare::ros
