#include <algorithm>
#include <limits>
#include <new>
#include <optional>
#include <utility>
#include <vector>

#include <wayfare/io/mcap.hpp>

#include "io/recording/mcap_records.hpp"

namespace wayfare::io {

using mcap::Opcode;
using mcap::put_record;

namespace {

constexpr std::size_t kMaxIds = 65535;

std::uint64_t unsigned_ns(LogTime time) { return static_cast<std::uint64_t>(time.nanoseconds()); }

std::string content_of(const McapSchema& s) { return packed(s.id, s.name, s.encoding, s.data); }

std::string content_of(const McapChannel& c) {
  return packed(c.id, c.schema, c.topic, c.message_encoding, mcap::pairs_of(c.metadata));
}

/// Position of a message within its chunk's records.
struct Entry {
  std::uint64_t time = 0;
  std::uint64_t offset = 0;
};

struct ChunkIndex {
  std::uint64_t first = 0, last = 0, offset = 0, length = 0, index_length = 0, size = 0;
  std::vector<std::pair<std::uint16_t, std::uint64_t>> index_offsets;
};

std::string content_of(const ChunkIndex& c) {
  std::string offsets;
  for (const auto& [channel, offset] : c.index_offsets) offsets += packed(channel, offset);
  return packed(c.first, c.last, c.offset, c.length, offsets, c.index_length, "", c.size, c.size);
}

}  // namespace

struct McapWriter::Impl {
  std::unique_ptr<ByteSink> sink;
  McapWriterOptions options;
  std::optional<Error> failed;
  bool closed = false;
  std::uint64_t position = 0;  ///< bytes of the file
  std::uint32_t data_crc = 0;  ///< of all of them
  std::vector<McapSchema> schemas;
  std::vector<McapChannel> channels;
  std::vector<std::uint32_t> sequences;
  std::string chunk;  ///< records of the current chunk
  std::map<std::uint16_t, std::vector<Entry>> entries;
  std::uint64_t first = 0, last = 0;  ///< times in that chunk
  std::vector<ChunkIndex> chunks;
  struct Metadata {
    std::string name;
    std::uint64_t offset, length;
  };
  std::vector<Metadata> metadata;
  McapStatistics statistics;

  Result<void> append(std::string_view bytes) {
    if (failed) return *failed;
    if (auto done = sink->write(bytes); !done) {
      failed = done.error();
      return done;
    }
    position += bytes.size();
    data_crc = mcap::crc(bytes, data_crc);
    return {};
  }

  [[nodiscard]] Result<void> usable() const {
    if (failed) return *failed;
    if (closed) return Error{ErrorCode::invalid, "the recording is closed"};
    return {};
  }

  void note(std::uint16_t channel, std::uint64_t time) {
    const bool empty = entries.empty();
    first = empty ? time : std::min(first, time);
    last = empty ? time : std::max(last, time);
    entries[channel].push_back({time, chunk.size()});
  }

  /// The chunk, followed by the index of each channel's messages; in one piece, so that the file
  /// contains both or neither.
  std::string closed_chunk(ChunkIndex& index) {
    const std::uint64_t size = chunk.size();
    const std::string head = packed(first, last, size, mcap::crc(chunk), "", size);
    std::string out;
    out.reserve(chunk.size() + 1024);
    out += static_cast<char>(Opcode::chunk);
    put(out, head.size() + size);
    out += head;
    out += chunk;
    index = {first, last, position, out.size(), 0, size, {}};
    for (const auto& [channel, list] : entries) {
      index.index_offsets.emplace_back(channel, position + out.size());
      std::string pairs;
      for (const Entry& e : list) pairs += packed(e.time, e.offset);
      put_record(out, Opcode::message_index, packed(channel, pairs));
    }
    index.index_length = out.size() - index.length;
    return out;
  }

  Result<void> flush() {
    if (auto ok = usable(); !ok) return ok;
    if (chunk.empty()) return {};
    ChunkIndex index;
    const std::string bytes = closed_chunk(index);
    if (auto done = append(bytes); !done) return done;
    chunks.push_back(std::move(index));
    ++statistics.chunks;
    if (!entries.empty()) {
      const auto from = LogTime::from_nanoseconds(static_cast<std::int64_t>(first));
      const auto until = LogTime::from_nanoseconds(static_cast<std::int64_t>(last));
      statistics.first = statistics.messages == 0 ? from : std::min(statistics.first, from);
      statistics.last = std::max(statistics.last, until);
    }
    for (const auto& [channel, list] : entries) {
      statistics.messages_of[channel] += list.size();
      statistics.messages += list.size();
    }
    chunk.clear();
    entries.clear();
    first = last = 0;  // as the format requires of a chunk without messages
    return {};
  }

  [[nodiscard]] std::string statistics_content() const {
    std::string counts;
    for (const auto& [channel, count] : statistics.messages_of) counts += packed(channel, count);
    constexpr std::uint32_t kAttachments = 0;
    return packed(statistics.messages, static_cast<std::uint16_t>(schemas.size()),
                  static_cast<std::uint32_t>(channels.size()), kAttachments,
                  static_cast<std::uint32_t>(metadata.size()), statistics.chunks,
                  unsigned_ns(statistics.first), unsigned_ns(statistics.last), counts);
  }

  /// Groups of records of one type, followed by the position of each group.
  [[nodiscard]] std::string summary() const {
    const std::uint64_t begin = position;
    std::string out, offsets;
    const auto group = [&](Opcode opcode, const auto& items, const auto& content) {
      const std::uint64_t at = out.size();
      for (const auto& item : items) put_record(out, opcode, content(item));
      if (out.size() == at) return;
      put_record(offsets, Opcode::summary_offset,
                 packed(static_cast<std::uint8_t>(opcode), begin + at, out.size() - at));
    };
    const auto plain = [](const auto& item) { return content_of(item); };
    group(Opcode::schema, schemas, plain);
    group(Opcode::channel, channels, plain);
    group(Opcode::statistics, std::vector<int>{0}, [&](int) { return statistics_content(); });
    group(Opcode::chunk_index, chunks, plain);
    group(Opcode::metadata_index, metadata,
          [](const Metadata& m) { return packed(m.offset, m.length, m.name); });
    const std::uint64_t offsets_at = begin + out.size();
    out += offsets;
    // The checksum covers the summary and the footer up to itself.
    out += packed(static_cast<std::uint8_t>(Opcode::footer), std::uint64_t{20}, begin, offsets_at);
    put(out, mcap::crc(out));
    out += mcap::kMagic;
    return out;
  }

  Result<void> close() {
    if (auto done = flush(); !done) return done;
    std::string end;
    put_record(end, Opcode::data_end, packed(data_crc));
    if (auto done = append(end); !done) return done;
    if (auto done = append(summary()); !done) return done;
    closed = true;
    auto done = sink->sync();
    if (!done) failed = done.error();
    return done;
  }

  ~Impl() {
    if (closed) return;
    try {
      static_cast<void>(close());
    } catch (const std::bad_alloc&) {  // the file is without its summary, as after a crash
    }
  }
};

McapWriter::McapWriter(detail::Owned<Impl> impl) : impl_(std::move(impl)) {}

Result<McapWriter> McapWriter::create(const std::string& path, const McapWriterOptions& options,
                                      const WriteOptions& write) {
  auto sink = FileSink::create(path, write);
  if (!sink) return sink.error();
  return create(std::move(*sink), options);
}

Result<McapWriter> McapWriter::create(std::unique_ptr<ByteSink> sink,
                                      const McapWriterOptions& options) {
  WAYFARE_EXPECTS(sink != nullptr, "a recording needs a sink");
  auto impl = detail::make_owned<Impl>();
  impl->sink = std::move(sink);
  impl->options = options;
  std::string bytes(mcap::kMagic);
  put_record(bytes, Opcode::header, packed(options.profile, options.library));
  if (auto done = impl->append(bytes); !done) return done.error();
  return McapWriter(std::move(impl));
}

Result<std::uint16_t> McapWriter::add_schema(const std::string& name, const std::string& encoding,
                                             const std::string& data) {
  if (auto ok = impl_->usable(); !ok) return ok.error();
  if (impl_->schemas.size() >= kMaxIds) return Error{ErrorCode::invalid, "too many schemas", name};
  if (std::max({name.size(), encoding.size(), data.size()}) >
      std::numeric_limits<std::uint32_t>::max())
    return Error{ErrorCode::invalid, "the schema is longer than 4 GB", name};
  const auto id = static_cast<std::uint16_t>(impl_->schemas.size() + 1);
  impl_->schemas.push_back({id, name, encoding, data});
  put_record(impl_->chunk, Opcode::schema, content_of(impl_->schemas.back()));
  return id;
}

Result<std::uint16_t> McapWriter::add_channel(const std::string& topic,
                                              const std::string& message_encoding,
                                              std::uint16_t schema, const McapMetadata& metadata) {
  if (auto ok = impl_->usable(); !ok) return ok.error();
  if (impl_->channels.size() >= kMaxIds)
    return Error{ErrorCode::invalid, "too many channels", topic};
  if (schema > impl_->schemas.size())
    return Error{ErrorCode::invalid,
                 "names schema " + std::to_string(schema) + ", which does not exist", topic};
  const auto id = static_cast<std::uint16_t>(impl_->channels.size());
  McapChannel channel{id, schema, topic, message_encoding, metadata};
  std::string content = content_of(channel);
  if (content.size() > std::numeric_limits<std::uint32_t>::max())
    return Error{ErrorCode::invalid, "the channel's description is longer than 4 GB", topic};
  impl_->channels.push_back(std::move(channel));
  impl_->sequences.push_back(0);
  put_record(impl_->chunk, Opcode::channel, content);
  return id;
}

Result<void> McapWriter::write(std::uint16_t channel, LogTime log_time, LogTime publish_time,
                               std::string_view data) {
  if (auto ok = impl_->usable(); !ok) return ok;
  if (channel >= impl_->channels.size())
    return Error{ErrorCode::invalid, "no channel " + std::to_string(channel)};
  if (log_time < LogTime() || publish_time < LogTime())
    return Error{ErrorCode::invalid, "a message's time is before the clock's epoch",
                 impl_->channels[channel].topic};
  impl_->note(channel, unsigned_ns(log_time));
  std::string& out = impl_->chunk;
  out += static_cast<char>(Opcode::message);
  put(out, std::uint64_t{22 + data.size()});
  put(out, channel);
  put(out, impl_->sequences[channel]++);
  put(out, unsigned_ns(log_time));
  put(out, unsigned_ns(publish_time));
  out += data;
  if (out.size() >= impl_->options.chunk_bytes) return impl_->flush();
  return {};
}

Result<void> McapWriter::add_metadata(const std::string& name, const McapMetadata& pairs) {
  if (auto done = impl_->flush(); !done) return done;
  std::string record;
  put_record(record, Opcode::metadata, packed(name, mcap::pairs_of(pairs)));
  const std::uint64_t at = impl_->position;
  if (auto done = impl_->append(record); !done) return done;
  impl_->metadata.push_back({name, at, record.size()});
  return {};
}

Result<void> McapWriter::flush() { return impl_->flush(); }

Result<void> McapWriter::sync() {
  if (auto done = impl_->flush(); !done) return done;
  auto done = impl_->sink->sync();
  if (!done) impl_->failed = done.error();
  return done;
}

Result<void> McapWriter::close() { return impl_->close(); }

const McapStatistics& McapWriter::statistics() const { return impl_->statistics; }
std::uint64_t McapWriter::bytes_written() const { return impl_->position; }

}  // namespace wayfare::io
