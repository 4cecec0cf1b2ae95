// Serialised messages of every type and encoding: damaged bytes are refused, or are those of
// another message that is written and read back the same.

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/ros/serialise.hpp>

#include "abuse/abuse.hpp"
#include "ros/sample_messages.hpp"

namespace wayfare::ros {
namespace {

std::string damaged(std::string bytes, Rng& rng) {
  for (std::uint64_t n = 1 + rng.below(3); n > 0 && !bytes.empty(); --n) {
    const std::size_t at = rng.below(bytes.size());
    switch (rng.below(5)) {
      case 0:
        bytes[at] = static_cast<char>(rng.below(256));
        break;
      case 1:  // a length of any size
        for (std::size_t i = at; i < std::min(at + 4, bytes.size()); ++i)
          bytes[i] = static_cast<char>(i == at + 3 ? rng.below(256) : 255);
        break;
      case 2:
        bytes.resize(at);
        break;
      case 3:
        bytes.erase(at, 1 + rng.below(8));
        break;
      default:
        bytes.insert(at, bytes.substr(rng.below(bytes.size()), rng.below(50)));
    }
  }
  return bytes;
}

/// Those of ROS 1, and CDR in both orders and both versions.
template <class M>
std::vector<std::pair<Dialect, std::string>> all_bytes(const M& message) {
  return {{Dialect::ros1, to_ros1(message)},
          {Dialect::ros2, to_cdr(message)},
          {Dialect::ros2, to_cdr(message, ByteOrder::big)}};
}

TEST(RosMessages, DamagedBytesAreRefusedOrAnotherMessage) {
  testing::for_each_message([](const auto& good) {
    using M = std::decay_t<decltype(good)>;
    SCOPED_TRACE(M::kType.name);
    for (const auto& [dialect, bytes] : all_bytes(good)) {
      for (std::uint64_t seed = 0; seed < 400; ++seed) {
        Rng rng(seed);
        const auto message = from_bytes<M>(damaged(bytes, rng), dialect);
        if (!message) {
          ASSERT_FALSE(message.error().message.empty());
          ASSERT_FALSE(message.error().source.empty());
          continue;
        }
        const std::string again = to_bytes(*message, dialect);
        const auto same = from_bytes<M>(again, dialect);
        ASSERT_TRUE(same) << same.error().to_string();
        ASSERT_EQ(to_bytes(*same, dialect), again);
      }
    }
  });
}

TEST(RosMessages, NoBytesAndTheHeadAlone) {
  testing::for_each_message([](const auto& good) {
    using M = std::decay_t<decltype(good)>;
    for (const std::string& bytes :
         {std::string(), std::string("\0", 1), std::string("\0\1\0", 3)}) {
      EXPECT_FALSE(from_cdr<M>(bytes));
      EXPECT_FALSE(from_ros1<M>(bytes));
    }
    const auto none = from_cdr<M>(std::string("\0\1\0\0", 4));
    ASSERT_FALSE(none);
    EXPECT_EQ(none.error().source, M::kType.name);
  });
}

TEST(RosMessages, EmptyMessagesRoundTrip) {
  testing::for_each_message([](const auto& good) {
    using M = std::decay_t<decltype(good)>;
    for (const auto& [dialect, bytes] : all_bytes(M{})) {
      const auto message = from_bytes<M>(bytes, dialect);
      ASSERT_TRUE(message) << M::kType.name;
      EXPECT_EQ(to_bytes(*message, dialect), to_bytes(M{}, dialect));
    }
    tests::expect_value_semantics(good, [](const M& m) { return to_cdr(m); });
  });
}

TEST(RosMessages, NamesOfAnyForm) {
  for (const char* name : {"", "/", "//", "a", "a/", "/a", "a/b/c", "a/msg", "a/msg/", "/msg/",
                           "/msg//msg/", "a/msg/b/msg/c"}) {
    EXPECT_LE(ros1_name(name).size(), ros2_name(name).size());
    static_cast<void>(ros1_name(ros2_name(name)));
  }
  EXPECT_EQ(ros1_name(ros2_name("a/b")), "a/b");
}

TEST(RosMessages, TwoThreadsWriteTheSame) {
  const auto both = tests::in_two_threads([](int) {
    std::string all;
    testing::for_each_message([&](const auto& message) {
      using M = std::decay_t<decltype(message)>;
      all += to_cdr(message) + to_ros1(message) + definition<M>(Dialect::ros1) +
             definition<M>(Dialect::ros2);
    });
    return all;
  });
  EXPECT_EQ(both[0], both[1]);
}

}  // namespace
}  // namespace wayfare::ros
