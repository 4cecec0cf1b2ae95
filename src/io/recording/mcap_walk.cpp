#include "io/recording/mcap_walk.hpp"

#include <algorithm>
#include <utility>

#include "io/recording/block_compression.hpp"

namespace wayfare::io::mcap {
namespace {

constexpr std::size_t kChunkHead = 40;  ///< without the name of its compression
constexpr std::size_t kLongestCompression = 16;

/// Records of the format, and private ones.
bool is_opcode(std::uint8_t code) { return (code >= 1 && code <= 15) || code >= 128; }

}  // namespace

std::optional<Record> take_record(std::string_view& rest, std::uint64_t at) {
  Cursor cursor(rest);
  const auto code = cursor.number<std::uint8_t>();
  const auto length = cursor.number<std::uint64_t>();
  const std::string_view content = cursor.bytes(length);
  if (!cursor.ok() || !is_opcode(code)) return std::nullopt;
  rest = cursor.rest();
  return Record{static_cast<Opcode>(code), at, content};
}

ChunkHead read_chunk_head(std::string_view content) {
  Cursor cursor(content);
  ChunkHead head;
  head.first = cursor.time();
  head.last = cursor.time();
  head.size = cursor.number<std::uint64_t>();
  head.crc = cursor.number<std::uint32_t>();
  head.compression = cursor.text();
  head.records = cursor.bytes(cursor.number<std::uint64_t>());
  head.whole = cursor.ok() && cursor.at_end();
  return head;
}

Result<std::string_view> records_of(const ChunkHead& chunk, std::size_t max_bytes,
                                    std::string& buffer) {
  if (!chunk.whole) return Error{ErrorCode::parse, "a chunk has an inconsistent length; skipped"};
  std::string_view records = chunk.records;
  if (!chunk.compression.empty()) {
    if (chunk.size > max_bytes)
      return Error{ErrorCode::unsupported,
                   "a chunk would need " + std::to_string(chunk.size) + " bytes; skipped"};
    auto unpacked = decompress_block(chunk.compression, records, chunk.size);
    if (!unpacked) return Error{unpacked.error().code, "a chunk " + unpacked.error().message};
    buffer = *std::move(unpacked);
    records = buffer;
  }
  if (chunk.size != records.size() || (chunk.crc != 0 && crc(records) != chunk.crc))
    return Error{ErrorCode::parse, "a chunk of " + std::to_string(records.size()) +
                                       " bytes has a wrong checksum; skipped"};
  return records;
}

std::optional<Record> Walk::record_at(std::uint64_t at) {
  const auto head = source_.fetch(at, kRecordHead, buffer_);
  if (!head) return std::nullopt;
  Cursor cursor(*head);
  const auto code = cursor.number<std::uint8_t>();
  const auto length = cursor.number<std::uint64_t>();
  if (!is_opcode(code) || length > source_.size() - at - kRecordHead) return std::nullopt;
  if (length > options_.max_record_bytes) return std::nullopt;
  const auto content = source_.fetch(at + kRecordHead, length, buffer_);
  if (!content) return std::nullopt;
  return Record{static_cast<Opcode>(code), at, *content};
}

bool Walk::is_chunk(std::uint64_t at, std::string_view head) {
  Cursor cursor(head);
  cursor.bytes(1);
  const auto length = cursor.number<std::uint64_t>();
  if (length > source_.size() - at - kRecordHead || length > options_.max_record_bytes)
    return false;
  cursor.bytes(16);
  const auto size = cursor.number<std::uint64_t>();
  cursor.bytes(4);
  const auto name = cursor.number<std::uint32_t>();
  if (!cursor.ok() || name > kLongestCompression || length < kChunkHead + name) return false;
  if (name == 0 && size != length - kChunkHead) return false;
  const auto content = source_.fetch(at + kRecordHead, length, probe_);
  if (!content) return false;
  const ChunkHead chunk = read_chunk_head(*content);
  effort_ += length + (name == 0 ? 0 : std::min<std::uint64_t>(size, options_.max_record_bytes));
  return chunk.crc != 0 && records_of(chunk, options_.max_record_bytes, unpacked_).has_value();
}

std::uint64_t Walk::next_chunk(std::uint64_t from) {
  constexpr std::uint64_t kWindow = 1U << 16U;
  const std::uint64_t least = kRecordHead + kChunkHead;
  std::string window;
  for (std::uint64_t at = from; at + least <= source_.size(); at += kWindow) {
    const std::uint64_t n = std::min(source_.size() - at, kWindow + least);
    const auto bytes = source_.fetch(at, n, window);
    if (!bytes) break;
    const char code = static_cast<char>(Opcode::chunk);
    for (std::size_t i = bytes->find(code); i < kWindow && i + least <= n;
         i = bytes->find(code, i + 1)) {
      if (is_chunk(at + i, bytes->substr(i, least))) return at + i;
      // Bounds the work on nested false chunks by the file's size.
      if (effort_ > 4 * source_.size()) return source_.size();
    }
  }
  return source_.size();
}

void Walk::run(const std::function<bool(const Record&)>& visit) {
  std::uint64_t at = kMagic.size();
  while (at < source_.size()) {
    const auto record = record_at(at);
    if (record) {
      at += record->bytes();
      if (!visit(*record) || record->opcode == Opcode::data_end) return;
      continue;
    }
    const std::uint64_t next = next_chunk(at + 1);
    const bool cut = next == source_.size();
    problems_.add(
        {ErrorCode::parse,
         cut ? "the file is cut off or damaged here; " + std::to_string(source_.size() - at) +
                   " bytes at its end are skipped"
             : "is damaged here; reading continues with the chunk at byte " + std::to_string(next),
         name_, 0, static_cast<std::size_t>(at)});
    if (cut) return;
    at = next;
  }
  // The last record is complete, but the file was never closed.
  problems_.add({ErrorCode::parse, "the file was not closed: nothing follows its last record",
                 name_, 0, static_cast<std::size_t>(at)});
}

}  // namespace wayfare::io::mcap
