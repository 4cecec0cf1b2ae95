// Fast CDR and types generated from IDL as the oracle of our serialisation: the same bytes for the
// same values, both ways.

#include "fast_messages.hpp"

#include <string>
#include <tuple>
#include <utility>

#include <gtest/gtest.h>

#include <wayfare/ros/serialise.hpp>

#include "our_messages.hpp"

namespace wayfare::testing {
namespace {

using Exchanged =
    std::tuple<ros::LaserScan, ros::PointCloud2, ros::Imu, ros::Odometry, ros::TfMessage,
               ros::OccupancyGrid, ros::PoseWithCovarianceStamped, ros::PoseArray, ros::Clock>;

template <class M>
void compare(std::uint32_t sample, std::uint32_t size) {
  const std::string name = ros::ros2_name(M::kType.name);
  SCOPED_TRACE(name + ", sample " + std::to_string(sample));
  peer::FastMessage theirs(name);
  theirs.fill(sample, size);
  const std::string bytes = theirs.to_bytes();
  const M ours = formula_message<M>(sample, size);
  ASSERT_EQ(ros::to_cdr(ours), bytes);
  const auto read = ros::from_cdr<M>(bytes);
  ASSERT_TRUE(read) << read.error().to_string();
  EXPECT_EQ(formula_difference(*read, sample, size), "");
  peer::FastMessage again(name);
  for (const ros::ByteOrder order : {ros::ByteOrder::little, ros::ByteOrder::big}) {
    ASSERT_TRUE(again.from_bytes(ros::to_cdr(ours, order)));
    EXPECT_EQ(again.difference(sample, size), "");
  }
}

template <std::size_t... I>
void compare_all(std::uint32_t sample, std::uint32_t size, std::index_sequence<I...>) {
  (compare<std::tuple_element_t<I, Exchanged>>(sample, size), ...);
}

TEST(CdrPeer, KnowsTheTypesThatNodesExchange) {
  EXPECT_EQ(peer::type_names().size(), std::tuple_size_v<Exchanged>);
}

TEST(CdrPeer, WritesAndReadsTheSameBytes) {
  for (std::uint32_t sample = 0; sample < 200; ++sample)
    compare_all(sample, 0, std::make_index_sequence<std::tuple_size_v<Exchanged>>());
  compare_all(7, 2000, std::make_index_sequence<std::tuple_size_v<Exchanged>>());
}

TEST(CdrPeer, NoticesAnotherValue) {
  auto message = formula_message<ros::Odometry>(3, 0);
  message.twist.covariance[35] += 1.0;
  EXPECT_NE(formula_difference(message, 3, 0), "");
  peer::FastMessage theirs("nav_msgs/msg/Odometry");
  ASSERT_TRUE(theirs.from_bytes(ros::to_cdr(message)));
  EXPECT_EQ(theirs.difference(3, 0), formula_difference(message, 3, 0));
  EXPECT_NE(theirs.difference(4, 0), "");
}

/// Neither reads what the other's message lacks.
TEST(CdrPeer, RefusesTheSameTruncatedBytes) {
  const std::string bytes = ros::to_cdr(formula_message<ros::LaserScan>(1, 0));
  for (std::size_t n = 4; n < bytes.size(); ++n) {
    peer::FastMessage theirs("sensor_msgs/msg/LaserScan");
    EXPECT_FALSE(theirs.from_bytes(bytes.substr(0, n))) << n;
    EXPECT_FALSE(ros::from_cdr<ros::LaserScan>(bytes.substr(0, n))) << n;
  }
}

}  // namespace
}  // namespace wayfare::testing
