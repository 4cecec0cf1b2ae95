#include "io/recording/mcap_walk.hpp"

#include <algorithm>
#include <utility>

namespace wayfare::io::mcap {

std::optional<std::string_view> content_at(const Source& source, std::uint64_t at, Opcode opcode,
                                           const McapReadOptions& options, std::string& buffer) {
  const auto head = head_at(source, at, buffer);
  if (!head || head->code != static_cast<std::uint8_t>(opcode) ||
      head->length > options.max_record_bytes)
    return std::nullopt;
  return source.fetch(at + kRecordHead, head->length, buffer);
}

namespace {

class Indexer {
 public:
  Indexer(const Source& source, const std::string& name, const McapReadOptions& options)
      : source_(source), name_(name), options_(options) {}

  Index run() {
    index_.contents.problems = Problems(options_.max_problems);
    index_.contents.bytes = source_.size();
    read_header();
    std::string buffer;
    std::uint64_t begin = 0;
    const char* missing = find_summary(buffer, begin);
    if (missing == nullptr && !take_summary(buffer, begin)) {
      missing = "has a summary without the positions of its messages";
    }
    index_.contents.indexed = missing == nullptr;
    if (missing != nullptr) {
      reset();
      index_.contents.problems.add(fault_at(
          source_.size(), std::string("the recording ") + missing + "; read from the front instead",
          name_));
      scan_all();
    }
    for (const auto& [id, schema] : index_.known.schemas) index_.contents.schemas.push_back(schema);
    for (const auto& [id, channel] : index_.known.channels)
      index_.contents.channels.push_back(channel);
    std::stable_sort(index_.entries.begin(), index_.entries.end(),
                     [](const IndexEntry& a, const IndexEntry& b) { return a.first < b.first; });
    return std::move(index_);
  }

 private:
  void read_header() {
    std::string buffer;
    if (const auto content = content_at(source_, kMagic.size(), Opcode::header, options_, buffer)) {
      Cursor c(*content);
      index_.contents.profile = c.text();
      index_.contents.library = c.text();
    }
  }

  /// Reads the summary and the footer up to its checksum; returns why there is none, else null.
  const char* find_summary(std::string& buffer, std::uint64_t& begin) const {
    constexpr std::uint64_t kFooter = kRecordHead + 20;
    const std::uint64_t tail = kFooter + kMagic.size();
    std::string end;
    const auto last = source_.size() >= tail + kMagic.size()
                          ? source_.fetch(source_.size() - tail, tail, end)
                          : std::nullopt;
    if (!last || last->substr(kFooter) != kMagic || (*last)[0] != static_cast<char>(Opcode::footer))
      return "was not closed, or its end is cut off";
    Cursor c(last->substr(kRecordHead));
    begin = c.number<std::uint64_t>();
    c.number<std::uint64_t>();
    const auto sum = c.number<std::uint32_t>();
    const std::uint64_t until = source_.size() - tail + kRecordHead + 16;
    if (begin == 0) return "has no summary";
    if (begin < kMagic.size() || begin > until || until - begin > options_.max_record_bytes)
      return "has a summary out of its bounds";
    const auto bytes = source_.fetch(begin, until - begin, buffer);
    if (!bytes) return "has a summary that cannot be read";
    if (sum != 0 && crc(*bytes) != sum) return "has a summary with a wrong checksum";
    // Sources in memory do not fill the buffer.
    if (buffer.data() != bytes->data()) buffer = std::string(*bytes);
    return nullptr;
  }

  bool take_statistics(Cursor c, std::uint64_t& in_chunks) {
    McapStatistics& s = index_.contents.statistics;
    s.messages = c.number<std::uint64_t>();
    c.bytes(2 + 4 + 4 + 4);
    in_chunks = s.chunks = c.number<std::uint32_t>();
    s.first = c.time();
    s.last = c.time();
    Cursor counts(c.text());
    while (!counts.at_end()) {
      const auto id = counts.number<std::uint16_t>();
      s.messages_of[id] = counts.number<std::uint64_t>();
    }
    return c.ok() && counts.ok();
  }

  void take_metadata(std::string_view content) {
    Cursor c(content);
    const std::string title(c.text());
    McapMetadata pairs = c.map();
    if (c.ok()) index_.contents.metadata[title] = std::move(pairs);
  }

  /// False where the summary is inconsistent or lacks the positions of the messages.
  bool take_summary(std::string_view rest, std::uint64_t begin) {
    const std::size_t size = rest.size();
    bool counted = false;
    std::uint64_t chunks = 0;
    while (!rest.empty()) {
      const std::uint64_t at = begin + (size - rest.size());
      if (rest[0] == static_cast<char>(Opcode::footer)) break;
      const auto record = take_record(rest, at);
      if (!record) return false;
      Cursor c(record->content);
      if (record->opcode == Opcode::schema || record->opcode == Opcode::channel) {
        if (!index_.known.take(*record)) return false;
      } else if (record->opcode == Opcode::chunk_index) {
        IndexEntry entry;
        entry.first = c.time();
        entry.last = c.time();
        entry.at = c.number<std::uint64_t>();
        const auto chunk = c.number<std::uint64_t>();
        c.text();
        const auto indexes = c.number<std::uint64_t>();
        if (!c.ok() || entry.at < kMagic.size() || entry.at >= begin || chunk > begin - entry.at ||
            indexes > begin - entry.at - chunk)
          return false;
        entry.until = entry.at + chunk + indexes;
        index_.entries.push_back(entry);
      } else if (record->opcode == Opcode::statistics) {
        if (!take_statistics(c, chunks)) return false;
        counted = true;
      } else if (record->opcode == Opcode::metadata_index) {
        std::string buffer;
        if (const auto content =
                content_at(source_, c.number<std::uint64_t>(), Opcode::metadata, options_, buffer))
          take_metadata(*content);
      }
    }
    return counted && chunks == index_.entries.size() && all_in_chunks(begin);
  }

  /// Whether the index contains each chunk of the data once and no message is outside of the
  /// chunks, where it has no index. `end` is that of the data.
  bool all_in_chunks(std::uint64_t end) const {
    std::map<std::uint64_t, std::uint64_t> chunks;
    for (const IndexEntry& entry : index_.entries) chunks.emplace(entry.at, entry.until);
    std::string buffer;
    std::size_t met = 0;
    for (std::uint64_t at = kMagic.size(); at < end;) {
      if (const auto chunk = chunks.find(at); chunk != chunks.end() && chunk->second > at) {
        at = chunk->second;
        ++met;
        continue;
      }
      const auto head = head_at(source_, at, buffer);
      if (!head) return false;
      const auto opcode = static_cast<Opcode>(head->code);
      if (opcode == Opcode::data_end) break;
      if (opcode == Opcode::message || opcode == Opcode::chunk || head->length > end - at)
        return false;
      at += kRecordHead + head->length;
    }
    return met == index_.entries.size();
  }

  void reset() {
    index_.known = {};
    index_.entries.clear();
    index_.contents.statistics = {};
    index_.contents.metadata.clear();
  }

  /// Reads all data; returns the number of messages of undescribed channels.
  std::size_t scan() {
    Messages messages(index_.known, name_, options_, index_.contents.problems);
    Walk walk(source_, name_, options_, index_.contents.problems);
    walk.run([&](const Record& record) {
      std::optional<IndexEntry> entry;
      messages.take(record, [&](const McapMessage& m) {
        count(m);
        if (!entry) entry = IndexEntry{record.at, m.log_time, m.log_time};
        entry->first = std::min(entry->first, m.log_time);
        entry->last = std::max(entry->last, m.log_time);
        return true;
      });
      if (record.opcode == Opcode::metadata) take_metadata(record.content);
      if (record.opcode == Opcode::chunk) ++index_.contents.statistics.chunks;
      if (entry) index_.entries.push_back(*entry);
      return true;
    });
    return messages.undescribed();
  }

  void count(const McapMessage& m) {
    McapStatistics& s = index_.contents.statistics;
    s.first = s.messages == 0 ? m.log_time : std::min(s.first, m.log_time);
    s.last = s.messages == 0 ? m.log_time : std::max(s.last, m.log_time);
    ++s.messages;
    ++s.messages_of[m.channel->id];
  }

  void scan_all() {
    const Problems before = index_.contents.problems;
    if (scan() == 0) return;
    // A damaged description may be repeated in a later chunk.
    Description found = std::move(index_.known);
    reset();
    index_.known = std::move(found);
    index_.contents.problems = before;
    scan();
  }

  const Source& source_;
  const std::string& name_;
  const McapReadOptions& options_;
  Index index_;
};

}  // namespace

Index make_index(const Source& source, const std::string& name, const McapReadOptions& options) {
  return Indexer(source, name, options).run();
}

}  // namespace wayfare::io::mcap
