#pragma once

// The pieces of MCAP files, for those the writer does not write: compressed chunks, messages
// outside of chunks.

#include <cstdint>
#include <optional>
#include <string>

#include "io/little.hpp"
#include "io/mcap_samples.hpp"
#if WAYFARE_HAS_LZ4
#include <lz4frame.h>
#endif
#if WAYFARE_HAS_ZSTD
#include <zstd.h>
#endif

namespace wayfare::testing {

/// Nothing where the tests were built without the library.
inline std::optional<std::string> compressed([[maybe_unused]] const std::string& name,
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

inline std::string mcap_text(const std::string& text) { return little(text.size(), 4) + text; }

inline std::string mcap_record(int opcode, const std::string& content) {
  return static_cast<char>(opcode) + little(content.size(), 8) + content;
}

inline std::string mcap_begin() {
  return "\x89MCAP0\r\n" + mcap_record(1, mcap_text("") + mcap_text("test"));
}

/// Channel 0, without a schema.
inline std::string mcap_channel(const std::string& topic) {
  return mcap_record(4, little(0, 4) + mcap_text(topic) + mcap_text("bytes") + little(0, 4));
}

/// A message of channel 0.
inline std::string mcap_message(const Remembered& m) {
  return mcap_record(5, little(0, 2) + little(m.sequence, 4) +
                            little(static_cast<std::uint64_t>(m.log_time.nanoseconds()), 8) +
                            little(static_cast<std::uint64_t>(m.publish_time.nanoseconds()), 8) +
                            m.data);
}

/// A chunk of `records` without a checksum, compressed where there is a name and the library for
/// it. The times in its head are what a reader without an index leaves aside.
inline std::string mcap_chunk(const std::string& name, const std::string& records,
                              std::uint64_t first = 0, std::uint64_t last = 0) {
  const auto packed = compressed(name, records);
  const std::string& stored = packed ? *packed : records;
  return mcap_record(6, little(first, 8) + little(last, 8) + little(records.size(), 8) +
                            little(0, 4) + mcap_text(packed ? name : "") +
                            little(stored.size(), 8) + stored);
}

/// The end of a file with a summary: `channel` and `index` are records, `before` the bytes in
/// front.
inline std::string mcap_end(std::uint64_t before, const std::string& channel,
                            const std::string& index, std::uint64_t messages, std::uint32_t chunks,
                            std::uint64_t first, std::uint64_t last) {
  const std::string data_end = mcap_record(15, little(0, 4));
  const std::string statistics = mcap_record(
      11, little(messages, 8) + little(0, 2) + little(1, 4) + little(0, 8) + little(chunks, 4) +
              little(first, 8) + little(last, 8) + mcap_text(little(0, 2) + little(messages, 8)));
  return data_end + channel + statistics + index +
         mcap_record(2, little(before + data_end.size(), 8) + little(0, 8) + little(0, 4)) +
         "\x89MCAP0\r\n";
}

/// What the summary says of a chunk `length` bytes long at `at`.
inline std::string mcap_chunk_index(std::uint64_t first, std::uint64_t last, std::uint64_t at,
                                    std::uint64_t length) {
  return mcap_record(8, little(first, 8) + little(last, 8) + little(at, 8) + little(length, 8) +
                            mcap_text("") + little(0, 8) + mcap_text("") + little(0, 8) +
                            little(0, 8));
}

}  // namespace wayfare::testing
