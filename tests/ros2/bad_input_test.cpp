// What a faulty publisher sends is refused, counted and reported once.

#include <limits>
#include <string>
#include <vector>

#include <wayfare/ros/nodes.hpp>
#include "ros2/own_domain.hpp"

namespace wayfare {
namespace {

using ::testing::HasSubstr;
using testing::own_node;
using testing::spin_until;

std::size_t occurrences(const std::string& text, const std::string& of) {
  std::size_t n = 0;
  for (std::size_t at = text.find(of); at != text.npos; at = text.find(of, at + 1)) ++n;
  return n;
}

TEST(Ros2BadInput, DamagedMessagesAreRefusedAndReportedOnce) {
  const auto sender = own_node("sender"), receiver = own_node("receiver");
  const auto raw = sender->raw().advertise("scan", ros::topic_type<ros::LaserScan>(), {});
  std::size_t received = 0;
  receiver->subscribe<ros::LaserScan>("scan", {}, [&](const auto&) { ++received; });
  ASSERT_TRUE(spin_until({receiver.get()}, [&] { return raw.subscribers() == 1; }));

  ros::LaserScan scan;
  scan.ranges.assign(10, 1.0F);
  const std::string good = ros::to_cdr(scan);
  std::string absurd = good;  // the number of ranges
  for (int i = 0; i < 4; ++i) absurd[good.size() - 48 + static_cast<std::size_t>(i)] = '\xFF';
  std::string other_encoding = good;
  other_encoding[1] = 3;  // parameter list
  const std::vector<std::string> bad = {"",
                                        good.substr(0, 3),
                                        good.substr(0, 30),
                                        absurd,
                                        good + std::string(100, 'x'),
                                        other_encoding};
  ::testing::internal::CaptureStderr();
  for (const std::string& bytes : bad) raw.publish(bytes);
  raw.publish(good);
  EXPECT_TRUE(spin_until({receiver.get()}, [&] { return received == 1; }));
  const std::string said = ::testing::internal::GetCapturedStderr();
  EXPECT_EQ(receiver->counts()[0].refused, bad.size());
  EXPECT_EQ(occurrences(said, "leaves out messages on '/scan' that are damaged"), 1U) << said;
}

TEST(Ros2BadInput, APublisherOfAnotherTypeIsReportedOnce) {
  const auto sender = own_node("sender"), receiver = own_node("receiver");
  auto texts = sender->publisher<ros::String>("scan", ros::Qos::latched());
  std::size_t received = 0;
  ::testing::internal::CaptureStderr();
  receiver->subscribe<ros::LaserScan>("scan", {}, [&](const auto&) { ++received; });
  std::string said;
  const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(2500);
  while (std::chrono::steady_clock::now() < end) {
    texts.publish({"a scan"});
    receiver->spin(0.05);
  }
  said = ::testing::internal::GetCapturedStderr();
  EXPECT_EQ(received, 0U);
  EXPECT_EQ(occurrences(said,
                        "leaves out a publisher of '/scan': its type is std_msgs/msg/String, "
                        "not sensor_msgs/msg/LaserScan"),
            1U)
      << said;
}

}  // namespace
}  // namespace wayfare
