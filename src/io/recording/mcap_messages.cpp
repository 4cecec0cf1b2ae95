#include "io/recording/mcap_messages.hpp"

#include <optional>
#include <string_view>

namespace wayfare::io::mcap {
namespace {

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
    if (!known_.take(record))
      fault(record.at, "a description is malformed or conflicts with another; skipped");
    return true;
  }
  if (record.opcode != Opcode::message) return true;
  McapMessage message;
  std::uint16_t id = 0;
  if (!read_message(record.content, id, message)) {
    fault(record.at, "a message is malformed; skipped");
    return true;
  }
  const auto channel = known_.channels.find(id);
  if (channel == known_.channels.end()) {
    ++undescribed_;
    fault(record.at,
          "a message of channel " + std::to_string(id) + ", which was not described; skipped");
    return true;
  }
  message.channel = &channel->second;
  return sink(message);
}

bool Messages::take_chunk(const Record& record, const Sink& sink) {
  const ChunkHead chunk = read_chunk_head(record.content);
  auto buffer = std::make_shared<std::string>();
  const auto records = records_of(chunk, options_.max_record_bytes, *buffer);
  if (!records) {
    Error error = records.error();
    error.source = name_;
    error.byte = static_cast<std::size_t>(record.at);
    problems_.add(std::move(error));
    return true;
  }
  const bool packed = !chunk.compression.empty();
  if (packed) unpacked_ = std::move(buffer);
  // Within a compressed chunk every position is that of the chunk.
  const std::uint64_t begin = record.at + record.bytes() - chunk.records.size();
  std::string_view rest = *records;
  while (!rest.empty()) {
    const std::uint64_t at = packed ? record.at : begin + (records->size() - rest.size());
    const auto inner = take_record(rest, at);
    if (!inner || inner->opcode == Opcode::chunk) {
      fault(at, "the rest of a chunk is malformed; skipped");
      return true;
    }
    if (!take_any(*inner, sink)) return false;
  }
  return true;
}

}  // namespace wayfare::io::mcap
