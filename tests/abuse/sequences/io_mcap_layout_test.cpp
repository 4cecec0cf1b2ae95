// MCAP files of any layout, also of those the writer does not write: compressed chunks, messages
// outside of chunks, descriptions that are repeated, files without an end or with an end that lies.

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <zlib.h>

#include <wayfare/core/random.hpp>
#include <wayfare/io/mcap.hpp>

#include "io/mcap_parts.hpp"

namespace wayfare::io {
namespace {

using ::wayfare::testing::little;
using ::wayfare::testing::mcap_begin;
using ::wayfare::testing::mcap_channel;
using ::wayfare::testing::mcap_chunk_index;
using ::wayfare::testing::mcap_end;
using ::wayfare::testing::mcap_message;
using ::wayfare::testing::mcap_record;
using ::wayfare::testing::mcap_text;
using ::wayfare::testing::read_all;
using ::wayfare::testing::Remembered;

/// An LZ4 frame whose blocks are stored: independent blocks of at most 64 KB, no checksums.
std::string lz4_frame(const std::string& bytes) {
  std::string out = "\x04\x22\x4d\x18\x60\x40\x82";
  if (!bytes.empty()) out += little(bytes.size() | 0x80000000U, 4) + bytes;
  return out + little(0, 4);
}

/// A Zstandard frame with one raw block, with the size of its content.
std::string zstd_frame(const std::string& bytes) {
  return "\x28\xb5\x2f\xfd\xa0" + little(bytes.size(), 4) + little(1 | bytes.size() << 3, 3) +
         bytes;
}

std::string chunk_of(const std::string& compression, const std::string& records, bool checksum,
                     std::uint64_t claimed) {
  const std::string stored = compression == "lz4"    ? lz4_frame(records)
                             : compression == "zstd" ? zstd_frame(records)
                                                     : records;
  const uLong crc =
      crc32(0, reinterpret_cast<const Bytef*>(records.data()), static_cast<uInt>(records.size()));
  return mcap_record(6, little(0, 16) + little(claimed, 8) + little(checksum ? crc : 0, 4) +
                            mcap_text(compression) + little(stored.size(), 8) + stored);
}

/// The compressions of this build.
std::vector<std::string> compressions() {
  std::vector<std::string> all = {""};
  for (const char* name : {"lz4", "zstd"}) {
    const auto reader = McapReader::parse(mcap_begin() + chunk_of(name, "", false, 0), "memory");
    bool reads = true;
    for (const Error& e : reader->contents().problems.first())
      reads = reads && e.code != ErrorCode::unsupported;
    if (reads) all.emplace_back(name);
  }
  return all;
}

struct File {
  std::string bytes;
  std::vector<Remembered> messages;
};

File any_file(Rng& rng, const std::vector<std::string>& compressions) {
  File file{mcap_begin(), {}};
  const std::string channel = mcap_channel("/a");
  std::string index;
  std::uint64_t in_chunks = 0;
  std::uint32_t chunks = 0;
  file.bytes += channel;
  for (std::uint64_t part = rng.below(12); part > 0; --part) {
    std::string records;
    std::vector<Remembered> own;
    for (std::uint64_t n = rng.below(6); n > 0; --n) {
      const auto time = LogTime::from_nanoseconds(static_cast<std::int64_t>(rng.below(40)));
      own.push_back({"/a", std::string(rng.below(20), 'x'),
                     static_cast<std::uint32_t>(rng.below(9)), time, time});
      if (rng.below(4) == 0) records += channel;
      records += mcap_message(own.back());
    }
    file.messages.insert(file.messages.end(), own.begin(), own.end());
    if (rng.below(3) == 0) {
      file.bytes += records;
      continue;
    }
    const std::string chunk = chunk_of(compressions[rng.below(compressions.size())], records,
                                       rng.below(2) == 0, records.size());
    // What the summary says of times must be so; what the chunk itself says is left aside.
    LogTime first, last;
    for (const Remembered& m : own) {
      first = &m == own.data() ? m.log_time : std::min(first, m.log_time);
      last = std::max(last, m.log_time);
    }
    index += mcap_chunk_index(static_cast<std::uint64_t>(first.nanoseconds()),
                              static_cast<std::uint64_t>(last.nanoseconds()), file.bytes.size(),
                              chunk.size());
    in_chunks += own.size();
    ++chunks;
    file.bytes += chunk;
  }
  if (rng.below(2) == 0)
    file.bytes += mcap_end(file.bytes.size(), channel, index, in_chunks, chunks, 0, 40);
  return file;
}

std::vector<Remembered> by_log_time(std::vector<Remembered> messages) {
  std::stable_sort(messages.begin(), messages.end(), [](const Remembered& a, const Remembered& b) {
    return a.log_time < b.log_time;
  });
  return messages;
}

TEST(McapLayouts, AreReadInBothOrders) {
  const auto known = compressions();
  for (std::uint64_t seed = 0; seed < 600; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Rng rng(seed);
    const File file = any_file(rng, known);
    const auto reader = McapReader::parse(file.bytes, "memory");
    ASSERT_TRUE(reader);
    ASSERT_EQ(reader->contents().statistics.messages, file.messages.size());
    ASSERT_EQ(read_all(*reader), file.messages);
    ASSERT_EQ(read_all(*reader, {.order = McapOrder::log_time}), by_log_time(file.messages));
    // Truncated: a prefix, in either order the same messages.
    const auto part =
        McapReader::parse(file.bytes.substr(0, 8 + rng.below(file.bytes.size() - 8)), "memory");
    ASSERT_TRUE(part);
    const auto read = read_all(*part);
    ASSERT_LE(read.size(), file.messages.size());
    ASSERT_TRUE(std::equal(read.begin(), read.end(), file.messages.begin()));
    ASSERT_EQ(read_all(*part, {.order = McapOrder::log_time}), by_log_time(read));
  }
}

TEST(McapLayouts, AnyDamageIsSurvived) {
  const auto known = compressions();
  for (std::uint64_t seed = 0; seed < 600; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Rng rng(seed);
    std::string bytes = any_file(rng, known).bytes;
    for (std::uint64_t n = 1 + rng.below(4); n > 0; --n) {
      const std::size_t at = 8 + rng.below(bytes.size() - 8);
      switch (rng.below(4)) {
        case 0:
          bytes[at] = static_cast<char>(rng.below(256));
          break;
        case 1:  // a length of any size
          bytes.replace(at, 8, little(rng(), 8));
          break;
        case 2:
          bytes.erase(at, rng.below(20));
          break;
        default:
          bytes.insert(at, bytes.substr(rng.below(bytes.size()), rng.below(60)));
      }
      if (bytes.size() < 9) break;
    }
    const auto reader = McapReader::parse(bytes, "memory", {.max_record_bytes = 1U << 16U});
    if (!reader) continue;
    for (const McapOrder order : {McapOrder::file, McapOrder::log_time}) {
      const auto all = read_all(*reader, {.order = order});
      ASSERT_LE(all.size(), bytes.size() / 31) << "more messages than there is room for";
      for (const Remembered& m : all) ASSERT_GE(m.log_time, LogTime());
    }
  }
}

// One bit turns the index of a chunk's messages to a message. Only the summary tells that it is
// not.
TEST(McapLayouts, AMessageThatTheSummaryDoesNotKnowIsReported) {
  auto bytes = std::make_shared<std::string>();
  auto writer = McapWriter::create(std::make_unique<::wayfare::testing::MemorySink>(bytes));
  ASSERT_TRUE(writer);
  ASSERT_TRUE(writer->add_channel("/a", "bytes"));
  ASSERT_TRUE(writer->write(0, LogTime::from_nanoseconds(5), LogTime::from_nanoseconds(5), "data"));
  ASSERT_TRUE(writer->flush());
  const std::size_t end = bytes->size();
  ASSERT_TRUE(writer->close());
  const std::size_t index = bytes->rfind('\x07', end - 22);
  ASSERT_EQ(end - index, 31U);  // opcode, length, channel, length, time and offset of one message
  (*bytes)[index] = 5;
  const auto reader = McapReader::parse(*bytes, "memory");
  ASSERT_TRUE(reader && reader->contents().indexed);
  Problems problems;
  ASSERT_EQ(read_all(*reader, {}, &problems).size(), 1U);
  ASSERT_EQ(problems.count(), 1U);
  EXPECT_EQ(problems.first()[0].byte, index);
}

// Sizes that a file claims are checked before memory is allocated for them.
TEST(McapLayouts, ClaimedSizesAllocateNothing) {
  const std::string begin = mcap_begin() + mcap_channel("/a");
  const std::string good = mcap_message({"/a", "x", 1, LogTime(), LogTime()});
  for (const std::uint64_t size : {std::uint64_t{1} << 30U, std::uint64_t{1'000'000'000'000},
                                   std::uint64_t{1} << 63U, UINT64_MAX, UINT64_MAX - 8}) {
    SCOPED_TRACE(size);
    std::vector<std::string> files = {begin + good + '\x05' + little(size, 8) + "x",
                                      begin + good + '\x06' + little(size, 8) + "x"};
    for (const char* name : {"", "lz4", "zstd", "unheard-of"})
      files.push_back(begin + good + chunk_of(name, good, true, size));
    for (const std::string& file : files) {
      const auto reader = McapReader::parse(file, "memory");
      ASSERT_TRUE(reader);
      EXPECT_FALSE(reader->contents().problems.empty());
      EXPECT_EQ(read_all(*reader).size(), 1U);
    }
    // In a summary.
    const std::string data = begin + good;
    for (const std::string& lie :
         {mcap_chunk_index(0, 5, size, 100), mcap_chunk_index(0, 5, 8, size)}) {
      const auto reader = McapReader::parse(
          data + mcap_end(data.size(), mcap_channel("/a"), lie, size, 1, 0, 5), "memory");
      ASSERT_TRUE(reader);
      EXPECT_EQ(reader->contents().statistics.messages, 1U);
      EXPECT_EQ(read_all(*reader, {.order = McapOrder::log_time}).size(), 1U);
    }
  }
}

}  // namespace
}  // namespace wayfare::io
