#include "io/recording/mcap_records.hpp"

#include <algorithm>
#include <utility>

namespace wayfare::io::mcap {
namespace {

constexpr std::size_t kChunkHead = 40;  ///< without the name of its compression
constexpr std::size_t kLongestCompression = 16;

/// Records of the format, and private ones.
bool is_opcode(std::uint8_t code) { return (code >= 1 && code <= 15) || code >= 128; }

/// A chunk's header and its records.
struct ChunkHead {
  LogTime first, last;
  std::uint64_t size = 0;
  std::uint32_t crc = 0;
  std::string_view compression, records;
  bool whole = false;  ///< the content's length matches the header
};

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

/// A chunk's records, decompressed to `buffer` where necessary. Errors, without a position:
/// damaged; larger than `max_bytes`.
Result<std::string_view> records_of(const ChunkHead& chunk, std::size_t max_bytes,
                                    std::string& buffer) {
  if (!chunk.whole) return Error{ErrorCode::parse, "a chunk has an inconsistent length; skipped"};
  std::string_view records = chunk.records;
  if (!chunk.compression.empty()) {
    if (chunk.size > max_bytes)
      return Error{ErrorCode::unsupported,
                   "a chunk would need " + std::to_string(chunk.size) + " bytes; skipped"};
    auto unpacked =
        decompress_block(chunk.compression, records, static_cast<std::size_t>(chunk.size));
    if (!unpacked) return Error{unpacked.error().code, "a chunk " + unpacked.error().message};
    buffer = *std::move(unpacked);
    records = buffer;
  }
  if (chunk.size != records.size() || (chunk.crc != 0 && crc(records) != chunk.crc))
    return Error{ErrorCode::parse, "a chunk of " + std::to_string(records.size()) +
                                       " bytes has a wrong checksum; skipped"};
  return records;
}

/// Parses a message record; false where it is malformed.
bool read_message(std::string_view content, std::uint16_t& channel, McapMessage& message) {
  Cursor c(content);
  channel = c.number<std::uint16_t>();
  message.sequence = c.number<std::uint32_t>();
  message.log_time = c.time();
  message.publish_time = c.time();
  message.data = c.rest();
  return c.ok();
}

}  // namespace

std::optional<RecordHead> head_at(const Source& source, std::uint64_t at, std::string& buffer) {
  const auto bytes = source.fetch(at, kRecordHead, buffer);
  if (!bytes) return std::nullopt;
  Cursor cursor(*bytes);
  const auto code = cursor.number<std::uint8_t>();
  return RecordHead{code, cursor.number<std::uint64_t>()};
}

std::optional<Record> take_record(std::string_view& rest, std::uint64_t at) {
  Cursor cursor(rest);
  const auto code = cursor.number<std::uint8_t>();
  const auto length = cursor.number<std::uint64_t>();
  const std::string_view content = cursor.bytes(length);
  if (!cursor.ok() || !is_opcode(code)) return std::nullopt;
  rest = cursor.rest();
  return Record{static_cast<Opcode>(code), at, content};
}

std::optional<Record> Walk::record_at(std::uint64_t at) {
  const auto head = head_at(source_, at, buffer_);
  if (!head || !is_opcode(head->code) || head->length > options_.max_record_bytes)
    return std::nullopt;
  const auto content = source_.fetch(at + kRecordHead, head->length, buffer_);
  if (!content) return std::nullopt;
  return Record{static_cast<Opcode>(head->code), at, *content};
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
    problems_.add(fault_at(
        at,
        cut ? "the file is cut off or damaged here; " + std::to_string(source_.size() - at) +
                  " bytes at its end are skipped"
            : "is damaged here; reading continues with the chunk at byte " + std::to_string(next),
        name_));
    if (cut) return;
    at = next;
  }
  // The last record is complete, but the file was never closed.
  problems_.add(fault_at(at, "the file was not closed: nothing follows its last record", name_));
}

bool Description::take(const Record& record) {
  Cursor c(record.content);
  if (record.opcode == Opcode::schema) {
    McapSchema s{c.number<std::uint16_t>(), std::string(c.text()), std::string(c.text()),
                 std::string(c.text())};
    if (!c.ok() || s.id == 0) return false;
    schemas.emplace(s.id, std::move(s));
    return true;
  }
  McapChannel n{c.number<std::uint16_t>(), c.number<std::uint16_t>(), std::string(c.text()),
                std::string(c.text()), c.map()};
  if (!c.ok()) return false;
  const auto [existing, inserted] = channels.emplace(n.id, n);
  return inserted || existing->second.topic == n.topic;
}

bool Messages::take(const Record& record, const Sink& sink) {
  unpacked_ = nullptr;
  return take_any(record, sink);
}

bool Messages::take_any(const Record& record, const Sink& sink) {
  if (record.opcode == Opcode::chunk) return take_chunk(record, sink);
  if (record.opcode == Opcode::schema || record.opcode == Opcode::channel) {
    return known_.take(record) ||
           fault(record.at, "a description is malformed or conflicts with another; skipped");
  }
  if (record.opcode != Opcode::message) return true;
  McapMessage message;
  std::uint16_t id = 0;
  if (!read_message(record.content, id, message))
    return fault(record.at, "a message is malformed; skipped");
  const auto channel = known_.channels.find(id);
  if (channel == known_.channels.end()) {
    ++undescribed_;
    return fault(record.at, "a message of channel " + std::to_string(id) +
                                ", which was not described; skipped");
  }
  message.channel = &channel->second;
  return sink(message);
}

bool Messages::take_chunk(const Record& record, const Sink& sink) {
  const ChunkHead chunk = read_chunk_head(record.content);
  auto buffer = std::make_shared<std::string>();
  const auto records = records_of(chunk, options_.max_record_bytes, *buffer);
  if (!records) return fault(record.at, records.error().message, records.error().code);
  const bool packed = !chunk.compression.empty();
  if (packed) unpacked_ = std::move(buffer);
  // Within a compressed chunk every position is that of the chunk.
  const std::uint64_t begin = record.at + record.bytes() - chunk.records.size();
  std::string_view rest = *records;
  while (!rest.empty()) {
    const std::uint64_t at = packed ? record.at : begin + (records->size() - rest.size());
    const auto inner = take_record(rest, at);
    if (!inner || inner->opcode == Opcode::chunk)
      return fault(at, "the rest of a chunk is malformed; skipped");
    if (!take_any(*inner, sink)) return false;
  }
  return true;
}

}  // namespace wayfare::io::mcap
