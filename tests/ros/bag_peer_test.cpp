// ROS 1's own library as the oracle for bags: it reads ours, and we read its compressed ones.

#include "bag_peer.hpp"

#include <algorithm>
#include <tuple>

#include <gtest/gtest.h>

#include <wayfare/io/bag.hpp>

#include "io/support.hpp"
#include "sample_recording.hpp"

namespace wayfare {
namespace {

/// By time, and at equal times by topic: librosbag_storage orders these differently.
std::vector<peer::Message> in_order(std::vector<peer::Message> all) {
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) {
    return std::tie(a.sec, a.nanosec, a.topic) < std::tie(b.sec, b.nanosec, b.topic);
  });
  return all;
}

std::vector<peer::Message> read_ours(const std::string& path) {
  std::vector<peer::Message> all;
  const auto bag = io::BagReader::open(path);
  EXPECT_TRUE(bag) << bag.error().to_string();
  if (!bag) return all;
  EXPECT_TRUE(bag->contents().indexed);
  EXPECT_TRUE(bag->read([&](const io::BagMessage& m) {
                   const std::int64_t ns = m.time.nanoseconds();
                   all.push_back({m.connection->topic, m.connection->type, m.connection->md5,
                                  std::string(m.data),
                                  static_cast<std::uint32_t>(ns / 1'000'000'000),
                                  static_cast<std::uint32_t>(ns % 1'000'000'000)});
                   return true;
                 })
                  .empty());
  return in_order(std::move(all));
}

TEST(BagPeer, ReadsTheSameMessages) {
  const testing::TemporaryFolder folder;
  testing::write_sample(folder / "a.bag", testing::sample_run(200));
  const auto theirs = in_order(peer::read_bag(folder / "a.bag"));
  // Scans, odometry, its transforms, gyro and truth; radar; the mountings.
  EXPECT_EQ(theirs.size(), 200U * 5 + 200 / 2 + 1);
  EXPECT_TRUE(theirs == read_ours(folder / "a.bag"));
}

TEST(BagPeer, ItsBagsAreReadWithAnyCompression) {
  const testing::TemporaryFolder folder;
  testing::write_sample(folder / "a.bag", testing::sample_run(200));
  const auto wanted = read_ours(folder / "a.bag");
  for (const std::string kind : {"none", "lz4", "bz2"}) {
    peer::copy_bag(folder / "a.bag", folder / kind + ".bag", kind);
    EXPECT_TRUE(read_ours(folder / kind + ".bag") == wanted) << kind;
  }
}

}  // namespace
}  // namespace wayfare
