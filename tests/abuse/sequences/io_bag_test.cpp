// Random calls of BagWriter beside a plain list of messages; the bag is then read whole, truncated
// and damaged. Random writes to a file that may not grow beyond a limit.

#include <sys/resource.h>

#include <algorithm>
#include <csignal>
#include <cstdint>
#include <filesystem>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/io/bag.hpp>

#include "abuse/abuse.hpp"
#include "io/support.hpp"

namespace wayfare::io {
namespace {

struct Message {
  std::string topic, data;
  LogTime time;

  bool operator==(const Message&) const = default;
};

constexpr std::int64_t kSecond_ns = 1'000'000'000;
const LogTime kLast = LogTime::from_nanoseconds((1LL << 32) * kSecond_ns - 1);

LogTime any_stamp(Rng& rng) {
  const auto small = static_cast<std::int64_t>(rng.below(100));
  switch (rng.below(6)) {
    case 0:
      return LogTime::from_nanoseconds(small);
    case 1:
      return kLast - Duration(small);
    default:
      return LogTime::from_nanoseconds(1'700'000'000 * kSecond_ns + small / 5);
  }
}

std::vector<Message> read_all(const BagReader& reader) {
  std::vector<Message> all;
  static_cast<void>(reader.read([&](const BagMessage& m) {
    all.push_back({m.connection->topic, std::string(m.data), m.time});
    return true;
  }));
  return all;
}

struct Bag {
  std::string bytes, calls;
  std::vector<std::string> topics;
  std::vector<Message> written;
};

Bag any_bag(Rng& rng, int calls) {
  Bag bag;
  BagWriter writer(1U << rng.below(12));
  for (int i = 0; i < calls; ++i) {
    const std::uint64_t kind = rng.below(20);
    if (kind == 0) {
      bag.calls += "connection ";
      const std::string topic = "/" + std::to_string(rng.below(3));  // may repeat
      EXPECT_EQ(writer.add_connection({77, topic, "std_msgs/String", "*", "string data", false}),
                bag.topics.size());
      bag.topics.push_back(topic);
    } else if (kind == 1) {
      bag.calls += "no_connection ";
      const auto none = static_cast<std::uint32_t>(bag.topics.size() + rng.below(2));
      EXPECT_FALSE(writer.write(none, kLast, "x"));
    } else if (kind == 2 && !bag.topics.empty()) {
      bag.calls += "time ";
      EXPECT_FALSE(writer.write(0, kLast + Duration(1), "x"));
      EXPECT_FALSE(writer.write(0, LogTime::from_nanoseconds(INT64_MAX), "x"));
      EXPECT_FALSE(writer.write(0, LogTime::from_nanoseconds(-1), "x"));
      EXPECT_FALSE(writer.write(0, LogTime::from_nanoseconds(INT64_MIN), "x"));
    } else if (kind == 3) {
      bag.calls += "copy ";
      BagWriter copy(writer);
      writer = std::move(copy);
    } else if (!bag.topics.empty()) {
      bag.calls += "write ";
      const auto id = static_cast<std::uint32_t>(rng.below(bag.topics.size()));
      Message m{bag.topics[id], std::string(rng.below(40), '\0'), any_stamp(rng)};
      for (char& c : m.data) c = static_cast<char>(rng.below(256));
      EXPECT_TRUE(writer.write(id, m.time, m.data));
      bag.written.push_back(std::move(m));
    }
  }
  bag.bytes = writer.finish();
  return bag;
}

TEST(BagSequences, AreReadAsTheListOfMessages) {
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    Rng rng(seed);
    const Bag bag = any_bag(rng, static_cast<int>(rng.below(120)));
    SCOPED_TRACE("seed " + std::to_string(seed) + ": " + bag.calls);
    ASSERT_FALSE(HasFailure());
    const auto reader = BagReader::parse(bag.bytes, "memory");
    ASSERT_TRUE(reader);
    EXPECT_TRUE(reader->contents().indexed);
    EXPECT_TRUE(reader->contents().problems.empty());
    EXPECT_EQ(reader->contents().messages, bag.written.size());
    ASSERT_EQ(reader->contents().connections.size(), bag.topics.size());
    for (std::size_t i = 0; i < bag.topics.size(); ++i)
      EXPECT_EQ(reader->contents().connections[i].topic, bag.topics[i]);
    ASSERT_EQ(read_all(*reader), bag.written);
    std::size_t count = 0;
    const std::size_t limit = rng.below(5) + 1;
    static_cast<void>(reader->read([&](const BagMessage&) { return ++count < limit; }));
    EXPECT_EQ(count, std::min(limit, bag.written.size()));
  }
}

TEST(BagSequences, TruncatedAnywhereAreAPrefix) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    Rng rng(seed);
    const Bag bag = any_bag(rng, 80);
    std::vector<std::size_t> cuts;
    for (int k = 0; k < 12; ++k) cuts.push_back(rng.below(bag.bytes.size()));
    std::sort(cuts.begin(), cuts.end());
    std::size_t before = 0;
    for (const std::size_t cut : cuts) {
      SCOPED_TRACE("seed " + std::to_string(seed) + ", cut " + std::to_string(cut));
      const auto reader = BagReader::parse(bag.bytes.substr(0, cut), "memory");
      ASSERT_EQ(reader.has_value(), cut >= 13);
      if (!reader) continue;
      EXPECT_FALSE(reader->contents().indexed);
      EXPECT_FALSE(reader->contents().problems.empty());
      const auto read = read_all(*reader);
      ASSERT_LE(before, read.size()) << "a longer bag has more messages";
      ASSERT_TRUE(std::equal(read.begin(), read.end(), bag.written.begin()));
      EXPECT_EQ(reader->contents().messages, read.size());
      before = read.size();
    }
  }
}

// The format has no checksum: one bit may change one message, or hide a chunk.
TEST(BagSequences, AFlippedBitMakesAtMostOneOtherMessage) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    Rng rng(seed);
    const Bag bag = any_bag(rng, 60);
    std::multiset<std::pair<LogTime, std::string>> written;
    for (const Message& m : bag.written) written.emplace(m.time, m.data);
    for (int k = 0; k < 12; ++k) {
      std::string bytes = bag.bytes;
      const std::size_t at = rng.below(bytes.size());
      const std::uint64_t bit = rng.below(8);
      bytes[at] = static_cast<char>(bytes[at] ^ (1 << bit));
      SCOPED_TRACE("seed " + std::to_string(seed) + ", bit " + std::to_string(bit) + " of byte " +
                   std::to_string(at));
      const auto reader = BagReader::parse(bytes, "memory");
      ASSERT_EQ(reader.has_value(), at >= 13);
      if (!reader) continue;
      auto left = written;
      std::size_t foreign = 0;
      for (const Message& m : read_all(*reader)) {
        const auto found = left.find({m.time, m.data});
        if (found == left.end()) {
          ++foreign;
        } else {
          left.erase(found);
        }
      }
      ASSERT_LE(foreign, 1U);
    }
  }
}

TEST(BagWriter, HasAnEnd) {
  BagWriter writer;
  const std::uint32_t id = writer.add_connection({0, "/a", "std_msgs/String", "*", "", false});
  ASSERT_TRUE(writer.write(id, kLast, "1"));
  const std::string bytes = writer.finish();
  EXPECT_TRUE(writer.finish().empty());
  const auto late = writer.write(id, kLast, "2");
  ASSERT_FALSE(late);
  EXPECT_NE(late.error().message.find("finished"), std::string::npos) << late.error().to_string();
  EXPECT_TRUE(writer.finish().empty());
  const auto reader = BagReader::parse(bytes, "memory");
  ASSERT_TRUE(reader);
  EXPECT_EQ(read_all(*reader).size(), 1U);
}

TEST(BagWriter, IsAValue) {
  BagWriter writer(64);
  for (const char* topic : {"/a", "/b"})
    writer.add_connection({0, topic, "std_msgs/String", "*", "string data", true});
  for (std::uint32_t i = 0; i < 9; ++i)
    ASSERT_TRUE(writer.write(i % 2, LogTime::from_nanoseconds(i), "abc"));
  tests::expect_value_semantics(writer, [](BagWriter& w) {
    EXPECT_TRUE(w.write(1, LogTime::from_nanoseconds(5), "more"));
    return w.finish();
  });
}

// A connection that readers would have to drop must not lose its messages.
TEST(BagWriter, EmptyNamesAreKept) {
  BagWriter writer;
  ASSERT_TRUE(writer.write(writer.add_connection({}), LogTime(), "x"));
  const auto reader = BagReader::parse(writer.finish(), "memory");
  ASSERT_TRUE(reader);
  EXPECT_TRUE(reader->contents().problems.empty());
  ASSERT_EQ(read_all(*reader).size(), 1U);
  EXPECT_EQ(read_all(*reader)[0], (Message{"", "x", LogTime()}));
}

TEST(BagSequences, TwoWritersInTwoThreadsAreIndependent) {
  const auto both = tests::in_two_threads([](int) {
    Rng rng(3);
    return any_bag(rng, 300).bytes;
  });
  EXPECT_EQ(both[0], both[1]);
  const auto reader = BagReader::parse(both[0], "memory");
  ASSERT_TRUE(reader);
  const auto read = tests::in_two_threads([&](int) { return read_all(*reader); });
  EXPECT_EQ(read[0], read[1]);
}

/// Files of this process may not grow beyond this.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) : signal_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;
  ~FileSizeLimit() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, signal_);
  }

 private:
  rlimit before_{};
  void (*signal_)(int);
};

TEST(FileSinkSequences, AWriteIsWholeOrUndone) {
  constexpr std::size_t kLimit = 20'000;
  const ::wayfare::testing::TemporaryFolder folder;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Rng rng(seed);
    const std::string path = folder / "sink";
    std::string model;
    std::size_t failures = 0;
    {
      auto sink = FileSink::create(path, {Existing::replace});
      ASSERT_TRUE(sink);
      EXPECT_FALSE(FileSink::create(path)) << "it exists";
      const FileSizeLimit limit(kLimit);
      for (int i = 0; i < 40; ++i) {
        const std::string bytes(rng.below(3000), static_cast<char>('a' + i % 26));
        const bool fits = model.size() + bytes.size() <= kLimit;
        const Result<void> done = (*sink)->write(bytes);
        ASSERT_EQ(done.has_value(), fits) << i;
        if (fits) model += bytes;
        failures += fits ? 0 : 1;
        if (rng.below(20) == 0) {
          ASSERT_TRUE((*sink)->sync());
        }
        ASSERT_EQ(std::filesystem::file_size(path), model.size());
      }
    }
    EXPECT_GT(failures, 0U);
    const auto content = read_file(path);
    ASSERT_TRUE(content);
    ASSERT_EQ(content->bytes, model);
  }
}

TEST(FileSinkSequences, AFailedWholeFileLeavesNothing) {
  const ::wayfare::testing::TemporaryFolder folder;
  const std::string path = folder / "whole";
  ASSERT_TRUE(write_file(path, "before"));
  {
    const FileSizeLimit limit(1000);
    EXPECT_FALSE(write_file(path, std::string(5000, 'x'), {Existing::replace}));
    EXPECT_FALSE(write_file(folder / "new", std::string(5000, 'x')));
  }
  const auto content = read_file(path);
  ASSERT_TRUE(content);
  EXPECT_EQ(content->bytes, "before");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1);
}

}  // namespace
}  // namespace wayfare::io
