// ROS 1's own headers as the oracle: the same bytes, checksums and names.

#include "peer.hpp"

#include <gtest/gtest.h>

#include <wayfare/ros/serialise.hpp>

#include "sample_messages.hpp"

namespace wayfare {
namespace {

/// A definition's fields and constants, without comments and insignificant spaces, and with the
/// header under its common name.
std::string plain(const std::string& definition) {
  std::string out, line;
  for (const char c : definition + "\n") {
    if (c != '\n') {
      line += c;
      continue;
    }
    line.resize(std::min(line.size(), line.find('#')));
    std::string words;
    for (const char w : line)
      if (w != ' ' && w != '\t') words += w;
    if (words.starts_with("Headerheader")) words = "std_msgs/Headerheader";
    if (!words.empty()) out += words + "\n";
    line.clear();
  }
  return out;
}

TEST(RosPeer, ReadsAndWritesTheSameBytes) {
  testing::for_each_message([](const auto& message) {
    using M = std::decay_t<decltype(message)>;
    const peer::Kind kind = peer::kind_of(std::string(M::kType.name));
    if (std::is_same_v<M, ros::RadarScan>) return;      // ours
    if (std::is_same_v<M, ros::ParticleCloud>) return;  // of ROS 2 alone
    EXPECT_EQ(kind.name, M::kType.name);
    EXPECT_EQ(kind.md5, M::kType.md5);
    const std::string bytes = ros::to_ros1(message);
    EXPECT_EQ(peer::written_again(kind.name, bytes), bytes) << kind.name;
  });
}

/// Constants are in the order of the published definition, so that the checksum of our text is the
/// published one.
TEST(RosPeer, DefinesMessagesWithoutNestedOnesTheSame) {
  EXPECT_EQ(plain(ros::definition<ros::LaserScan>(ros::Dialect::ros1)).substr(0, 180),
            plain(peer::kind_of("sensor_msgs/LaserScan").definition).substr(0, 180));
  const std::string ours = plain(ros::definition<ros::NavSatFix>(ros::Dialect::ros1));
  const std::string theirs = plain(peer::kind_of("sensor_msgs/NavSatFix").definition);
  for (const char* constant : {"int8STATUS_NO_FIX=-1", "uint16SERVICE_GALILEO=8",
                               "uint8COVARIANCE_TYPE_KNOWN=3", "uint16service"}) {
    EXPECT_NE(ours.find(constant), std::string::npos) << constant;
    EXPECT_NE(theirs.find(constant), std::string::npos) << constant;
  }
}

}  // namespace
}  // namespace wayfare
