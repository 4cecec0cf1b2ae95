// Chunks compressed by LZ4 and Zstandard read like uncompressed ones.

#include <functional>
#include <optional>

#include "mcap_samples.hpp"
#include "support.hpp"
#if WAYFARE_HAS_LZ4
#include <lz4frame.h>
#endif
#if WAYFARE_HAS_ZSTD
#include <zstd.h>
#endif

namespace wayfare::io {
namespace {

using ::testing::HasSubstr;
using ::wayfare::testing::MemorySink;
using ::wayfare::testing::read_all;

/// nullopt where the tests were built without the library.
std::optional<std::string> compressed([[maybe_unused]] const std::string& name,
                                      [[maybe_unused]] const std::string& bytes) {
#if WAYFARE_HAS_LZ4
  if (name == "lz4") {
    std::string out(LZ4F_compressFrameBound(bytes.size(), nullptr), '\0');
    out.resize(LZ4F_compressFrame(out.data(), out.size(), bytes.data(), bytes.size(), nullptr));
    return out;
  }
#endif
#if WAYFARE_HAS_ZSTD
  if (name == "zstd") {
    std::string out(ZSTD_compressBound(bytes.size()), '\0');
    out.resize(ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), 3));
    return out;
  }
#endif
  return std::nullopt;
}

std::uint64_t number(const std::string& bytes, std::size_t at, std::size_t size) {
  std::uint64_t value = 0;
  for (std::size_t i = size; i-- > 0;)
    value = value << 8 | static_cast<std::uint8_t>(bytes[at + i]);
  return value;
}

std::string little(std::uint64_t value, std::size_t size) {
  std::string out;
  for (std::size_t i = 0; i < size; ++i) out += static_cast<char>(value >> (8 * i));
  return out;
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
    if (!compressed(GetParam(), "x")) GTEST_SKIP() << "built without " << GetParam();
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

INSTANTIATE_TEST_SUITE_P(Kinds, McapCompressed, ::testing::Values("lz4", "zstd"),
                         [](const auto& kind) { return std::string(kind.param); });

}  // namespace
}  // namespace wayfare::io
