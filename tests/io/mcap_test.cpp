// MCAP recordings: round trips, also through another library, and the effect of damage.

#include <zlib.h>

#include <cstdlib>
#include <fstream>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "mcap_samples.hpp"
#include "node_peer.hpp"
#include "support.hpp"

namespace wayfare::io {
namespace {

using ::testing::HasSubstr;
using ::wayfare::testing::MemorySink;
using ::wayfare::testing::read_all;
using ::wayfare::testing::Remembered;
using ::wayfare::testing::TemporaryFolder;

LogTime at(std::int64_t ns) { return LogTime::from_nanoseconds(ns); }

/// A recording and the expected messages.
struct Sample {
  std::string bytes;
  std::vector<Remembered> messages;  ///< as written
  std::vector<std::size_t> flushed;  ///< bytes after each flush
};

/// Two streams in `chunks` chunks of `per_chunk` messages each; times not quite in order.
Sample sample(int chunks, int per_chunk, bool close = true) {
  Sample out;
  auto bytes = std::make_shared<std::string>();
  auto writer = McapWriter::create(std::make_unique<MemorySink>(bytes));
  EXPECT_TRUE(writer);
  const auto schema = writer->add_schema("foxglove.Log", "jsonschema", R"({"type":"object"})");
  const std::uint16_t raw = *writer->add_channel("/radar/raw", "bytes", 0, {{"baud", "921600"}});
  const std::uint16_t text = *writer->add_channel("/log", "json", *schema);
  std::mt19937 random(7);
  std::uint32_t sequences[2] = {0, 0};
  for (int c = 0; c < chunks; ++c) {
    for (int i = 0; i < per_chunk; ++i) {
      const bool is_raw = random() % 2 == 0;
      std::string data(random() % 40, '\0');
      for (char& b : data) b = static_cast<char>(random());
      const LogTime time = at(1'700'000'000'000'000'000 + 1000 * (c * per_chunk + i) -
                              static_cast<int>(random() % 3000));
      EXPECT_TRUE(writer->write(is_raw ? raw : text, time, time + Duration(5), data));
      out.messages.push_back({is_raw ? "/radar/raw" : "/log", data, sequences[is_raw ? 0 : 1]++,
                              time, time + Duration(5)});
    }
    EXPECT_TRUE(writer->flush());
    out.flushed.push_back(bytes->size());
  }
  if (close) {
    EXPECT_TRUE(writer->add_metadata("place", {{"room", "12"}}));
    EXPECT_TRUE(writer->close());
  }
  out.bytes = *bytes;
  return out;
}

TEST(Mcap, ReadsWhatWasWritten) {
  const Sample s = sample(5, 40);
  const auto reader = McapReader::parse(s.bytes, "m");
  ASSERT_TRUE(reader);
  const McapContents& contents = reader->contents();
  EXPECT_TRUE(contents.problems.empty());
  EXPECT_TRUE(contents.indexed);
  EXPECT_EQ(contents.library, "wayfare");
  EXPECT_EQ(contents.statistics.messages, 200U);
  EXPECT_EQ(contents.statistics.chunks, 5U);
  ASSERT_EQ(contents.channels.size(), 2U);
  EXPECT_EQ(contents.channels[0].metadata.at("baud"), "921600");
  EXPECT_EQ(contents.schemas.at(0).data, R"({"type":"object"})");
  EXPECT_EQ(contents.metadata.at("place").at("room"), "12");
  Problems problems;
  EXPECT_EQ(read_all(*reader, {}, &problems), s.messages);
  EXPECT_TRUE(problems.empty());
  const auto [first, last] =
      std::minmax_element(s.messages.begin(), s.messages.end(),
                          [](const auto& a, const auto& b) { return a.log_time < b.log_time; });
  EXPECT_EQ(contents.statistics.first, first->log_time);
  EXPECT_EQ(contents.statistics.last, last->log_time);
}

TEST(Mcap, ByTimeIsAStableSort) {
  // Without a summary the same order is derived from the data.
  for (const bool closed : {true, false}) {
    const Sample s = sample(6, 30, closed);
    std::vector<Remembered> sorted = s.messages;
    std::stable_sort(sorted.begin(), sorted.end(),
                     [](const auto& a, const auto& b) { return a.log_time < b.log_time; });
    const auto reader = McapReader::parse(s.bytes, "m");
    ASSERT_TRUE(reader);
    EXPECT_EQ(reader->contents().indexed, closed);
    EXPECT_EQ(read_all(*reader, {McapOrder::log_time}), sorted);
  }
}

TEST(Mcap, SelectsTopicsAndTimes) {
  const Sample s = sample(6, 30);
  const auto reader = McapReader::parse(s.bytes, "m");
  const LogTime from = s.messages[50].log_time, until = s.messages[120].log_time;
  for (const auto order : {McapOrder::file, McapOrder::log_time}) {
    const auto some = read_all(*reader, {order, {"/log"}, from, until});
    const auto wanted = std::count_if(s.messages.begin(), s.messages.end(), [&](const auto& m) {
      return m.topic == "/log" && m.log_time >= from && m.log_time <= until;
    });
    EXPECT_EQ(some.size(), static_cast<std::size_t>(wanted));
    EXPECT_GT(wanted, 10);
    int calls = 0;
    reader->read({order}, [&](const McapMessage&) { return ++calls < 3; });
    EXPECT_EQ(calls, 3);
  }
}

TEST(Mcap, ATruncatedFileGivesEveryFlushedChunk) {
  const Sample s = sample(4, 5);
  for (std::size_t n = 0; n <= s.bytes.size(); ++n) {
    const auto reader = McapReader::parse(s.bytes.substr(0, n), "m");
    if (n < 8) {
      ASSERT_FALSE(reader);
      continue;
    }
    ASSERT_TRUE(reader) << n;
    // A chunk is readable once its last byte is present; its index is not part of it.
    const auto messages = read_all(*reader);
    std::size_t least = 0;
    for (const std::size_t end : s.flushed) least += n >= end ? 5 : 0;
    ASSERT_GE(messages.size(), least) << n;
    ASSERT_LE(messages.size(), least + 5) << n;
    ASSERT_TRUE(std::equal(messages.begin(), messages.end(), s.messages.begin())) << n;
    ASSERT_EQ(reader->contents().statistics.messages, messages.size()) << n;
    ASSERT_EQ(reader->contents().problems.empty(), n == s.bytes.size()) << n;
    ASSERT_EQ(read_all(*reader, {McapOrder::log_time}).size(), messages.size()) << n;
  }
}

TEST(Mcap, AFlippedBitAffectsOneChunkAtMost) {
  const Sample s = sample(8, 12);
  std::mt19937 random(3);
  for (int i = 0; i < 2000; ++i) {
    std::string bytes = s.bytes;
    // Not in the magic, which identifies the format.
    const std::size_t where = 8 + random() % (bytes.size() - 8);
    bytes[where] = static_cast<char>(bytes[where] ^ (1 << (random() % 8)));
    const auto reader = McapReader::parse(bytes, "m");
    ASSERT_TRUE(reader) << where;
    const auto messages = read_all(*reader);
    ASSERT_GE(messages.size(), 7 * 12U) << where;
    for (const Remembered& m : messages)
      ASSERT_TRUE(std::find(s.messages.begin(), s.messages.end(), m) != s.messages.end()) << where;
  }
}

TEST(Mcap, ReportsThePositionOfADamagedChunk) {
  const Sample s = sample(3, 10);
  std::string bytes = s.bytes;
  bytes[s.flushed[1] - 700] = static_cast<char>(bytes[s.flushed[1] - 700] ^ 1);
  const auto reader = McapReader::parse(bytes, "m");
  Problems problems;
  const auto messages = read_all(*reader, {}, &problems);
  EXPECT_EQ(messages.size(), 20U);
  ASSERT_EQ(problems.count(), 1U);
  EXPECT_THAT(problems.first()[0].message, HasSubstr("wrong checksum"));
  EXPECT_EQ(problems.first()[0].byte, s.flushed[0]);
}

TEST(Mcap, NamesACompressionItDoesNotRead) {
  const Sample s = sample(1, 3, false);
  std::string bytes = s.bytes;
  // The chunk begins after the header; "br4" replaces the empty name of its compression.
  const std::size_t chunk = bytes.find('\x06', 8 + 9 + 4 + 4 + 7);
  const std::size_t name = chunk + 9 + 8 + 8 + 8 + 4;
  bytes.insert(name + 4, "br4");
  bytes[name] = 3;
  bytes[chunk + 1] = static_cast<char>(bytes[chunk + 1] + 3);
  const auto reader = McapReader::parse(bytes, "m");
  ASSERT_TRUE(reader);
  Problems problems;
  EXPECT_TRUE(read_all(*reader, {}, &problems).empty());
  ASSERT_FALSE(problems.empty());
  EXPECT_EQ(problems.first()[0].code, ErrorCode::unsupported);
  EXPECT_THAT(problems.first()[0].message, HasSubstr("'br4'"));
}

TEST(Mcap, SurvivesAnyDamage) {
  const Sample s = sample(4, 10);
  std::mt19937 random(20260101);
  const auto below = [&](std::size_t n) { return n == 0 ? 0 : random() % n; };
  for (int i = 0; i < 3000; ++i) {
    std::string bytes = s.bytes;
    for (std::size_t k = 1 + below(5); k-- > 0 && bytes.size() > 8;) {
      const std::size_t where = 8 + below(bytes.size() - 8);
      switch (below(4)) {
        case 0:
          bytes.resize(where);
          break;
        case 1:
          bytes[where] = static_cast<char>(random());
          break;
        case 2:
          bytes.erase(where, 1 + below(30));
          break;
        default:
          bytes.insert(where, bytes.substr(below(bytes.size()), below(200)));
      }
    }
    const auto reader = McapReader::parse(bytes, "m", {.max_problems = 5});
    if (!reader) continue;
    ASSERT_LE(reader->contents().problems.first().size(), 5U);
    LogTime last;
    reader->read({McapOrder::log_time}, [&](const McapMessage& m) {
      EXPECT_NE(m.channel, nullptr);
      last = m.log_time;
      return true;
    });
    read_all(*reader);
  }
}

TEST(Mcap, AFullDiskKeepsWhatWasFlushed) {
  auto bytes = std::make_shared<std::string>();
  auto writer = McapWriter::create(std::make_unique<MemorySink>(bytes, 5000));
  const std::uint16_t channel = *writer->add_channel("/raw", "bytes");
  int kept = 0;
  Result<void> done;
  for (int i = 0; i < 100; ++i) {
    done = writer->write(channel, at(i), at(i), std::string(200, 'x'));
    if (done) done = writer->flush();
    if (!done) break;
    ++kept;
  }
  ASSERT_FALSE(done);
  EXPECT_THAT(done.error().message, HasSubstr("no room"));
  EXPECT_FALSE(writer->write(channel, at(1), at(1), "x"));
  EXPECT_FALSE(writer->close());
  EXPECT_GT(kept, 10);
  const auto reader = McapReader::parse(*bytes, "m");
  EXPECT_EQ(read_all(*reader).size(), static_cast<std::size_t>(kept));
}

TEST(Mcap, AFullFileIsAnError) {
  const auto writer = McapWriter::create("/dev/full", {}, {.existing = Existing::replace});
  ASSERT_FALSE(writer);
  EXPECT_THAT(writer.error().to_string(), HasSubstr("/dev/full: cannot be written"));
}

TEST(Mcap, RejectsInvalidMessages) {
  auto bytes = std::make_shared<std::string>();
  auto writer = McapWriter::create(std::make_unique<MemorySink>(bytes));
  EXPECT_FALSE(writer->write(0, at(1), at(1), "x"));
  EXPECT_FALSE(writer->add_channel("/a", "json", 3));
  const auto channel = writer->add_channel("/a", "json");
  ASSERT_TRUE(channel);
  EXPECT_FALSE(writer->write(*channel, at(-1), at(1), "x"));
  EXPECT_TRUE(writer->write(*channel, at(1), at(1), "x"));
  EXPECT_TRUE(writer->close());
  EXPECT_FALSE(writer->write(*channel, at(2), at(2), "x"));
  EXPECT_EQ(read_all(*McapReader::parse(*bytes, "m")).size(), 1U);
  const TemporaryFolder folder;
  EXPECT_TRUE(McapWriter::create(folder / "a.mcap"));
  const auto again = McapWriter::create(folder / "a.mcap");
  ASSERT_FALSE(again);
  EXPECT_THAT(again.error().message, HasSubstr("exists already"));
  EXPECT_FALSE(McapReader::open(folder / "none.mcap"));
  EXPECT_FALSE(McapReader::open(folder.path().string()));
  EXPECT_FALSE(McapReader::parse("not a recording", "m"));
}

TEST(Mcap, AFileReadsAsMemoryDoes) {
  const Sample s = sample(5, 40);
  const TemporaryFolder folder;
  std::ofstream(folder / "a.mcap", std::ios::binary) << s.bytes;
  const auto reader = McapReader::open(folder / "a.mcap");
  ASSERT_TRUE(reader);
  EXPECT_EQ(read_all(*reader), s.messages);
  EXPECT_EQ(read_all(*reader, {McapOrder::log_time}),
            read_all(*McapReader::parse(s.bytes, "m"), {McapOrder::log_time}));
}

// --- read by another library ---------------------------------------------------------------------

TEST(Mcap, AnotherLibraryReadsTheSame) {
  const std::string missing = wayfare::testing::peer_missing(WAYFARE_MCAP_PEER, "@mcap/core");
  if (!missing.empty()) GTEST_SKIP() << missing;
  const Sample s = sample(5, 40);
  const TemporaryFolder folder;
  std::ofstream(folder / "a.mcap", std::ios::binary) << s.bytes;
  std::vector<Remembered> sorted = s.messages;
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const auto& a, const auto& b) { return a.log_time < b.log_time; });
  for (const std::string how : {"indexed", "streaming"}) {
    std::ostringstream wanted;
    for (const Remembered& m : how == "indexed" ? sorted : s.messages)
      wanted << m.topic << (m.topic == "/log" ? " foxglove.Log " : " - ") << m.sequence << ' '
             << m.log_time.nanoseconds() << ' ' << m.publish_time.nanoseconds() << ' '
             << ::crc32(0, reinterpret_cast<const Bytef*>(m.data.data()),
                        static_cast<uInt>(m.data.size()))
             << '\n';
    wanted << (how == "indexed" ? "total 200 chunks 5\nmetadata place\n" : "done\n");
    int status = 0;
    const std::string command =
        "node '" WAYFARE_MCAP_PEER "/read.js' '" + folder / "a.mcap" + "' " + how + " 2>&1";
    EXPECT_EQ(wayfare::testing::output_of(command, status), wanted.str());
    EXPECT_EQ(status, 0);
  }
}

}  // namespace
}  // namespace wayfare::io
