// Chunks compressed by LZ4 and Zstandard read like uncompressed ones.

#include <algorithm>
#include <functional>

#include "io/mcap_parts.hpp"
#include "io/mcap_samples.hpp"
#include "io/support.hpp"

namespace wayfare::io {
namespace {

using ::testing::HasSubstr;
using ::wayfare::testing::compressed;
using ::wayfare::testing::little;
using ::wayfare::testing::mcap_begin;
using ::wayfare::testing::mcap_channel;
using ::wayfare::testing::mcap_chunk;
using ::wayfare::testing::mcap_chunk_index;
using ::wayfare::testing::mcap_end;
using ::wayfare::testing::mcap_message;
using ::wayfare::testing::MemorySink;
using ::wayfare::testing::read_all;
using ::wayfare::testing::Remembered;
using ::wayfare::testing::TemporaryFolder;

std::size_t number(const std::string& bytes, std::size_t at, std::size_t size) {
  std::uint64_t value = 0;
  for (std::size_t i = size; i-- > 0;)
    value = value << 8 | static_cast<std::uint8_t>(bytes[at + i]);
  return static_cast<std::size_t>(value);
}

/// A recording of three chunks that was never closed.
std::string plain() {
  auto bytes = std::make_shared<std::string>();
  auto writer = McapWriter::create(std::make_unique<MemorySink>(bytes));
  const std::uint16_t channel = *writer->add_channel("/text", "bytes");
  for (int i = 0; i < 30; ++i) {
    const LogTime time = LogTime::from_nanoseconds(1000 - 10 * (i / 10) + i);
    EXPECT_TRUE(writer->write(channel, time, time, "message " + std::to_string(i)));
    if (i % 10 == 9) {
      EXPECT_TRUE(writer->flush());
    }
  }
  return *bytes;
}

using Change = std::function<void(std::string& records, std::uint64_t& size)>;

/// The same with every chunk compressed; `change` may damage each of them.
std::string packed(const std::string& name, const Change& change = {}) {
  const std::string from = plain();
  std::string out = from.substr(0, 8);
  for (std::size_t at = 8; at < from.size();) {
    const std::size_t length = number(from, at + 1, 8);
    if (from[at] == 6) {
      const std::size_t head = at + 9;  // first, last, size, crc; an empty name; length
      std::string records = *compressed(name, from.substr(head + 40, length - 40));
      std::uint64_t size = number(from, head + 16, 8);
      if (change) change(records, size);
      const std::string content = from.substr(head, 16) + little(size, 8) +
                                  from.substr(head + 24, 4) + little(name.size(), 4) + name +
                                  little(records.size(), 8) + records;
      out += '\x06' + little(content.size(), 8) + content;
    } else if (from[at] != 7) {  // no message index: its offsets would be wrong
      out += from.substr(at, 9 + length);
    }
    at += 9 + length;
  }
  return out;
}

class McapCompressed : public ::testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    if (!compressed(GetParam(), "x"))
      GTEST_SKIP() << "built without " << GetParam() << " (Debian: lib" << GetParam() << "-dev)";
  }
};

TEST_P(McapCompressed, ReadsLikeUncompressed) {
  const auto reader = McapReader::parse(packed(GetParam()), "m");
  const auto wanted = McapReader::parse(plain(), "m");
  ASSERT_EQ(read_all(*wanted).size(), 30U);
  EXPECT_EQ(read_all(*reader), read_all(*wanted));
  // In order of time, messages of three chunks are buffered at once.
  EXPECT_EQ(read_all(*reader, {McapOrder::log_time}), read_all(*wanted, {McapOrder::log_time}));
}

TEST_P(McapCompressed, DamageAffectsTheChunkOnly) {
  int chunk = 0;
  const std::string bytes = packed(GetParam(), [&](std::string& records, std::uint64_t&) {
    if (chunk++ % 3 == 1) records[records.size() / 2] ^= 0x55, records[20] ^= 0x55;
  });
  Problems problems;
  EXPECT_EQ(read_all(*McapReader::parse(bytes, "m"), {}, &problems).size(), 20U);
  EXPECT_THAT(problems.first()[0].to_string(), HasSubstr("a chunk "));
}

TEST_P(McapCompressed, WrongSizesAreRejected) {
  for (const std::uint64_t wrong : {std::uint64_t{0}, std::uint64_t{100}, std::uint64_t{5000},
                                    std::uint64_t{1} << 40, UINT64_MAX}) {
    const std::string bytes =
        packed(GetParam(), [&](std::string&, std::uint64_t& size) { size = wrong; });
    EXPECT_TRUE(read_all(*McapReader::parse(bytes, "m")).empty()) << wrong;
  }
}

TEST_P(McapCompressed, ADamagedTailIsSurvived) {
  const std::string bytes = packed(GetParam());
  const auto reader = McapReader::parse(bytes.substr(0, bytes.size() - 40), "m");
  EXPECT_EQ(read_all(*reader).size(), 20U);
  // The second chunk's opcode is damaged: reading continues at the third, found by its checksum.
  std::string broken = bytes;
  const std::size_t first = 8 + 9 + number(bytes, 9, 8);
  broken[first + 9 + number(bytes, first + 1, 8)] = '\x77';
  EXPECT_EQ(read_all(*McapReader::parse(broken, "m")).size(), 20U);
}

/// Messages of one channel; each says its number, with bytes enough to lie outside of the string.
Remembered numbered(std::uint32_t number, std::int64_t time) {
  const LogTime at = LogTime::from_nanoseconds(time);
  return {"/text", "message " + std::to_string(number) + std::string(40, '.'), number, at, at};
}

TEST_P(McapCompressed, AMessageBehindTheChunkKeepsItsOwnBytes) {
  // Two messages in a chunk, three outside of any: all are held at once, those from the file by the
  // bytes of their own record.
  std::vector<Remembered> wanted;
  std::string records, loose;
  for (const std::int64_t time : {100, 100, 200, 201, 202}) {
    wanted.push_back(numbered(static_cast<std::uint32_t>(wanted.size()), time));
    (time == 100 ? records : loose) += mcap_message(wanted.back());
  }
  const TemporaryFolder folder;
  const std::string path = folder / "mixed.mcap";
  const std::string chunk = mcap_chunk(GetParam(), records);
  ASSERT_TRUE(write_file(path, mcap_begin() + mcap_channel("/text") + chunk + loose));
  const auto reader = McapReader::open(path);
  ASSERT_TRUE(reader);
  EXPECT_EQ(read_all(*reader, {McapOrder::log_time}), wanted);
}

TEST_P(McapCompressed, ASummaryThatLeavesMessagesOutIsNotUsed) {
  // The index has the chunk at 100 alone; the message behind it is found from the front.
  const std::vector<Remembered> wanted = {numbered(0, 50), numbered(1, 100)};
  const std::string channel = mcap_channel("/text");
  std::string bytes = mcap_begin() + channel;
  const std::string chunk = mcap_chunk(GetParam(), mcap_message(wanted[1]), 100, 100);
  const std::string index = mcap_chunk_index(100, 100, bytes.size(), chunk.size());
  bytes += chunk;
  const auto whole =
      McapReader::parse(bytes + mcap_end(bytes.size(), channel, index, 1, 1, 100, 100), "m");
  EXPECT_TRUE(whole->contents().indexed);
  bytes += mcap_message(wanted[0]);
  const auto reader =
      McapReader::parse(bytes + mcap_end(bytes.size(), channel, index, 2, 1, 50, 100), "m");
  EXPECT_FALSE(reader->contents().indexed);
  EXPECT_EQ(reader->contents().statistics.messages, 2U);
  EXPECT_EQ(read_all(*reader, {McapOrder::log_time}), wanted);
}

TEST_P(McapCompressed, OfEqualTimesTheFirstWrittenComesFirst) {
  // More messages than the chunk has bytes: their numbers must not reach into the next chunk's.
  std::vector<Remembered> wanted;
  std::string first, second;
  for (std::uint32_t i = 0; i < 3000; ++i) {
    wanted.push_back({"/text", "", 0, LogTime::from_nanoseconds(100), LogTime()});
    first += mcap_message(wanted.back());
  }
  wanted.push_back({"/text", "last", 0, LogTime::from_nanoseconds(100), LogTime()});
  second = mcap_message(wanted.back());
  const std::string chunk = mcap_chunk(GetParam(), first);
  ASSERT_LT(chunk.size(), 3000U);
  const auto reader = McapReader::parse(
      mcap_begin() + mcap_channel("/text") + chunk + mcap_chunk(GetParam(), second), "m");
  EXPECT_EQ(read_all(*reader, {McapOrder::log_time}), wanted);
}

INSTANTIATE_TEST_SUITE_P(Kinds, McapCompressed, ::testing::Values("lz4", "zstd"),
                         [](const auto& kind) { return std::string(kind.param); });

}  // namespace
}  // namespace wayfare::io
