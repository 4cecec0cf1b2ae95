// Between our node on Cyclone DDS and a program on Fast DDS with types generated from IDL: every
// value of every message, both ways.

#include <signal.h>

#include <cstdint>
#include <string>
#include <vector>

#include "io/support.hpp"
#include "ros/nodes/processes.hpp"
#include "ros2/own_domain.hpp"
#include "ros2/peer/our_messages.hpp"

namespace wayfare {
namespace {

using testing::own_node;
using testing::Process;
using testing::spin_until;

constexpr std::uint32_t kMessages = 20;

template <class M>
class Ros2FastDds : public ::testing::Test {
 public:
  [[nodiscard]] std::string type() const { return ros::ros2_name(M::kType.name); }
  /// Elements of its sequences.
  [[nodiscard]] static std::uint32_t size() {
    if (std::is_same_v<M, ros::OccupancyGrid>) return 300'000;  // in several packets
    if (std::is_same_v<M, ros::PointCloud2>) return 5000;       // and as many fields
    return std::is_same_v<M, ros::LaserScan> ? 1080 : 3;
  }
  [[nodiscard]] Process peer(const std::string& mode, std::vector<std::string> options) const {
    std::vector<std::string> command = {WAYFARE_FASTDDS_PEER, mode, "rt/topic", type()};
    options.insert(options.end(), {"--size", std::to_string(size()), "--domain",
                                   std::to_string(testing::own_domain())});
    command.insert(command.end(), options.begin(), options.end());
    return Process(command, folder_ / "peer.txt");
  }

 private:
  testing::TemporaryFolder folder_;
};

using Exchanged = ::testing::Types<ros::LaserScan, ros::PointCloud2, ros::Imu, ros::Odometry,
                                   ros::TfMessage, ros::OccupancyGrid,
                                   ros::PoseWithCovarianceStamped, ros::PoseArray, ros::Clock>;
TYPED_TEST_SUITE(Ros2FastDds, Exchanged);

TYPED_TEST(Ros2FastDds, ReadsOurMessagesAndWeRead) {
  const auto node = own_node("ours");
  auto publisher = node->publisher<TypeParam>("topic");
  Process reader = this->peer("subscribe", {std::to_string(kMessages)});
  ASSERT_TRUE(spin_until({node.get()}, [&] { return publisher.subscribers() == 1; }))
      << reader.output();
  for (std::uint32_t i = 0; i < kMessages; ++i)
    publisher.publish(testing::formula_message<TypeParam>(i, this->size()));
  EXPECT_EQ(reader.wait(30.0), 0) << reader.output();

  std::uint32_t received = 0;
  std::string different;
  const auto listener = own_node("listener");
  // A writer knows of a reader before the reader knows of it: what it sends meanwhile is kept.
  listener->subscribe<TypeParam>("topic", ros::Qos::latched(1000), [&](const TypeParam& message) {
    different += testing::formula_difference(message, received++, this->size());
  });
  Process writer = this->peer(
      "publish", {"--count", std::to_string(kMessages), "--wait-for", "1", "--transient-local"});
  EXPECT_TRUE(spin_until({listener.get()}, [&] { return received == kMessages; }))
      << received << writer.output();
  EXPECT_EQ(different, "");
  EXPECT_EQ(listener->counts()[0].lost + listener->counts()[0].refused, 0U);
  EXPECT_EQ(writer.wait(30.0), 0) << writer.output();
}

using Ros2FastDdsMap = Ros2FastDds<ros::OccupancyGrid>;

TEST_F(Ros2FastDdsMap, ReachesLateReadersBothWays) {
  const auto node = own_node("ours");
  auto map = node->publisher<ros::OccupancyGrid>("topic", ros::Qos::latched());
  map.publish(testing::formula_message<ros::OccupancyGrid>(0, size()));
  Process reader = peer("subscribe", {"1", "--transient-local"});
  EXPECT_EQ(reader.wait(30.0), 0) << reader.output();
  map = node->publisher<ros::OccupancyGrid>("other", ros::Qos::latched());

  Process writer =
      peer("publish", {"--count", "1", "--transient-local", "--depth", "1", "--stay-s", "20"});
  ASSERT_TRUE(spin_until({node.get()}, [&] { return !node->raw().topics().empty(); }))
      << writer.output();
  std::vector<std::string> differences;
  const auto late = own_node("late");
  late->subscribe<ros::OccupancyGrid>("topic", ros::Qos::latched(), [&](const auto& m) {
    differences.push_back(testing::formula_difference(m, 0, size()));
  });
  ASSERT_TRUE(spin_until({late.get()}, [&] { return !differences.empty(); })) << writer.output();
  EXPECT_EQ(differences, std::vector<std::string>{""});
  writer.end(SIGTERM);
}

}  // namespace
}  // namespace wayfare
