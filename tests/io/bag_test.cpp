// ROS 1 bags: round trips, and damage that affects only the damaged part.

#include <wayfare/io/bag.hpp>

#include <random>

#include "support.hpp"

namespace wayfare::io {
namespace {

using ::testing::HasSubstr;
using ::wayfare::testing::TemporaryFolder;

struct Read {
  std::vector<std::string> messages;  ///< topic, time and data
  Problems problems;
};

Read read_all(const BagReader& bag) {
  Read all;
  all.problems = bag.read([&](const BagMessage& m) {
    all.messages.push_back(m.connection->topic + " " + std::to_string(m.time.nanoseconds()) + " " +
                           std::string(m.data));
    return true;
  });
  return all;
}

constexpr std::int64_t kStart = 1'600'000'000'000'000'000;
constexpr int kMessages = 60;

/// Messages on two topics, about ten per chunk.
std::string sample() {
  BagWriter writer(600);
  const auto a = writer.add_connection({0, "/a", "std_msgs/String", "m1", "string data\n"});
  const auto b = writer.add_connection({0, "/b", "std_msgs/Int32", "m2", "int32 data\n", true});
  for (int i = 0; i < kMessages; ++i)
    EXPECT_TRUE(writer.write(i % 3 == 0 ? b : a, LogTime::from_nanoseconds(kStart + 7 * i),
                             "message " + std::to_string(i)));
  return writer.finish();
}

std::vector<std::string> expected() {
  std::vector<std::string> all;
  for (int i = 0; i < kMessages; ++i)
    all.push_back((i % 3 == 0 ? "/b " : "/a ") + std::to_string(kStart + 7 * i) + " message " +
                  std::to_string(i));
  return all;
}

TEST(Bag, RoundTrip) {
  const auto bag = BagReader::parse(sample(), "m");
  ASSERT_TRUE(bag) << bag.error().to_string();
  EXPECT_TRUE(bag->contents().indexed);
  EXPECT_TRUE(bag->contents().problems.empty());
  EXPECT_EQ(bag->contents().messages, kMessages);
  ASSERT_EQ(bag->contents().connections.size(), 2U);
  const BagConnection& b = bag->contents().connections[1];
  EXPECT_EQ(b.topic, "/b");
  EXPECT_EQ(b.type, "std_msgs/Int32");
  EXPECT_EQ(b.md5, "m2");
  EXPECT_EQ(b.definition, "int32 data\n");
  EXPECT_TRUE(b.latching);
  EXPECT_FALSE(bag->contents().connections[0].latching);
  const Read all = read_all(*bag);
  EXPECT_EQ(all.messages, expected());
  EXPECT_TRUE(all.problems.empty());
}

TEST(Bag, AFileReadsAsMemoryDoesAndGzipIsDecompressed) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_file(folder / "a.bag", sample()));
  EXPECT_EQ(read_all(*BagReader::open(folder / "a.bag")).messages, expected());
  ASSERT_EQ(std::system(("gzip '" + folder / "a.bag" + "'").c_str()), 0);
  EXPECT_EQ(read_all(*BagReader::open(folder / "a.bag.gz")).messages, expected());
  EXPECT_FALSE(BagReader::open(folder / "none.bag"));
}

TEST(Bag, OtherFormatsAreRejectedByName) {
  const auto older = BagReader::parse("#ROSBAG V1.2\nrest", "m");
  ASSERT_FALSE(older);
  EXPECT_EQ(older.error().code, ErrorCode::unsupported);
  EXPECT_THAT(older.error().to_string(), HasSubstr("m: is a bag of another version than 2.0"));
  EXPECT_THAT(BagReader::parse("#", "m").error().to_string(), HasSubstr("does not begin as"));
}

TEST(Bag, ATruncatedBagKeepsItsWholeMessages) {
  const std::string whole = sample();
  std::size_t most = 0;
  for (std::size_t n = 13; n < whole.size(); n += 37) {
    const auto bag = BagReader::parse(whole.substr(0, n), "m");
    ASSERT_TRUE(bag) << n;
    EXPECT_FALSE(bag->contents().indexed);
    EXPECT_FALSE(bag->contents().problems.empty());
    const Read all = read_all(*bag);
    EXPECT_EQ(all.messages.size(), bag->contents().messages);
    EXPECT_GE(all.messages.size(), most);  // more bytes, no fewer messages
    most = all.messages.size();
    const auto wanted = expected();
    ASSERT_TRUE(std::equal(all.messages.begin(), all.messages.end(), wanted.begin()));
  }
  EXPECT_EQ(most, kMessages);
}

TEST(Bag, DamageAffectsOneChunk) {
  const std::string whole = sample();
  // Within a message's header; at a chunk's own; in the length of one's data.
  const std::size_t chunk = whole.find("compression=none", whole.find("message 30")) - 8;
  for (const std::size_t at : {whole.find("message 30") - 40, chunk, chunk + 40}) {
    std::string bytes = whole;
    bytes.replace(at, 12, "\xff\xff\xff\xff\xff\xff\xff\xff\xff\xff\xff\xff");
    const Read all = read_all(*BagReader::parse(bytes, "m"));
    EXPECT_FALSE(all.problems.empty());
    EXPECT_GE(all.messages.size(), 30U) << at;
    EXPECT_LT(all.messages.size(), kMessages) << at;
  }
}

TEST(Bag, AnUnknownCompressionIsNamed) {
  std::string bytes = sample();
  for (std::size_t at = 0; (at = bytes.find("compression=none", at)) != std::string::npos;)
    bytes.replace(at, 16, "compression=brot");
  const Read all = read_all(*BagReader::parse(bytes, "m"));
  EXPECT_TRUE(all.messages.empty());
  EXPECT_EQ(all.problems.first()[0].code, ErrorCode::unsupported);
  EXPECT_THAT(all.problems.first()[0].to_string(), HasSubstr("compressed by 'brot'"));
}

TEST(Bag, DuplicateChunksAreReadTwice) {
  const std::string whole = sample();
  const std::size_t begin = 13 + 8 + 4096, end = whole.find("compression=none", begin + 200) - 8;
  const std::string first = whole.substr(begin, end - begin);
  const auto bag = BagReader::parse(whole.substr(0, end) + first + whole.substr(end), "m");
  const Read all = read_all(*bag);
  EXPECT_GT(all.messages.size(), kMessages + 3U);
  EXPECT_LT(all.messages.size(), kMessages + 20U);
  EXPECT_EQ(bag->contents().connections.size(), 2U);
}

TEST(Bag, SurvivesAnyDamage) {
  const std::string whole = sample();
  std::mt19937 random(20260102);
  const auto below = [&](std::size_t n) { return n == 0 ? 0 : random() % n; };
  for (int i = 0; i < 2000; ++i) {
    std::string bytes = whole;
    // The head's padding is most of the file and is not read.
    for (std::size_t k = 1 + below(5); k-- > 0;) {
      const std::size_t where = below(4) == 0 ? 13 + below(100) : 4117 + below(bytes.size() - 4117);
      switch (below(4)) {
        case 0:
          bytes.resize(std::max<std::size_t>(where, 4200));
          break;
        case 1:
          bytes[std::min(where, bytes.size() - 1)] = static_cast<char>(random());
          break;
        case 2:
          if (bytes.size() > 4300) bytes.erase(std::min(where, bytes.size() - 40), 1 + below(30));
          break;
        default:
          bytes.insert(std::min(where, bytes.size()),
                       bytes.substr(below(bytes.size()), below(200)));
      }
    }
    const auto bag = BagReader::parse(bytes, "m", {.max_problems = 5});
    if (!bag) continue;
    const Read all = read_all(*bag);
    ASSERT_LE(all.problems.first().size(), 5U);
    if (!bag->contents().indexed) {
      ASSERT_EQ(all.messages.size(), bag->contents().messages);
    }
  }
}

TEST(Bag, RejectsInvalidMessages) {
  BagWriter writer;
  EXPECT_FALSE(writer.write(0, LogTime::from_nanoseconds(1), "x"));
  const auto c = writer.add_connection({0, "/a", "std_msgs/String", "m", ""});
  EXPECT_FALSE(writer.write(c, LogTime::from_nanoseconds(-1), "x"));
  EXPECT_FALSE(writer.write(c, LogTime::from_seconds(5e9), "x"));
  EXPECT_TRUE(writer.write(c, LogTime::from_nanoseconds(1), ""));
  EXPECT_EQ(read_all(*BagReader::parse(writer.finish(), "m")).messages.size(), 1U);
}

}  // namespace
}  // namespace wayfare::io
