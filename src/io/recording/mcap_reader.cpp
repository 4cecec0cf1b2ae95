#include <wayfare/io/mcap.hpp>

#include <algorithm>
#include <queue>
#include <tuple>
#include <utility>

#include "io/recording/mcap_records.hpp"

namespace wayfare::io {
namespace mcap {
namespace {

/// A chunk, or a message outside of chunks.
struct IndexEntry {
  std::uint64_t at = 0;
  LogTime first, last;
  std::uint64_t until = 0;  ///< end of the chunk and of the message indexes behind it; by a summary
};

struct Index {
  McapContents contents;
  Description known;
  std::vector<IndexEntry> entries;  ///< in order of their first time
};

/// The content of the record of type `opcode` at `at`, if there is one. May use `buffer`.
std::optional<std::string_view> content_at(const Source& source, std::uint64_t at, Opcode opcode,
                                           const McapReadOptions& options, std::string& buffer) {
  const auto head = head_at(source, at, buffer);
  if (!head || head->code != static_cast<std::uint8_t>(opcode) ||
      head->length > options.max_record_bytes)
    return std::nullopt;
  return source.fetch(at + kRecordHead, head->length, buffer);
}

/// The contents of a recording and the positions of its messages: from its summary, or from all its
/// data where that is missing or inconsistent. Faults are reported in the contents' problems.
class Indexer {
 public:
  Indexer(const Source& source, const std::string& name, const McapReadOptions& options)
      : source_(source), name_(name), options_(options) {}

  Index run() {
    index_.contents.problems = Problems(options_.max_problems);
    index_.contents.bytes = source_.size();
    std::string buffer;
    if (const auto content = content_at(source_, kMagic.size(), Opcode::header, options_, buffer)) {
      Cursor c(*content);
      index_.contents.profile = c.text();
      index_.contents.library = c.text();
    }
    std::uint64_t begin = 0;
    const char* missing = find_summary(buffer, begin);
    if (missing == nullptr && !take_summary(buffer, begin))
      missing = "has a summary without the positions of its messages";
    index_.contents.indexed = missing == nullptr;
    if (missing != nullptr) {
      start_again({});
      index_.contents.problems.add(fault_at(
          source_.size(), std::string("the recording ") + missing + "; read from the front instead",
          name_));
      const Problems before = index_.contents.problems;
      // A damaged description may be repeated in a later chunk.
      if (scan() != 0) {
        start_again(std::move(index_.known));
        index_.contents.problems = before;
        scan();
      }
    }
    for (const auto& [id, schema] : index_.known.schemas) index_.contents.schemas.push_back(schema);
    for (const auto& [id, channel] : index_.known.channels)
      index_.contents.channels.push_back(channel);
    std::stable_sort(index_.entries.begin(), index_.entries.end(),
                     [](const IndexEntry& a, const IndexEntry& b) { return a.first < b.first; });
    return std::move(index_);
  }

 private:
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
  [[nodiscard]] bool all_in_chunks(std::uint64_t end) const {
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

  void start_again(Description known) {
    index_.known = std::move(known);
    index_.entries.clear();
    index_.contents.statistics = {};
    index_.contents.metadata.clear();
  }

  /// Reads all data; returns the number of messages of undescribed channels.
  std::size_t scan() {
    McapStatistics& s = index_.contents.statistics;
    Messages messages(index_.known, name_, options_, index_.contents.problems);
    Walk walk(source_, name_, options_, index_.contents.problems);
    walk.run([&](const Record& record) {
      std::optional<IndexEntry> entry;
      messages.take(record, [&](const McapMessage& m) {
        s.first = s.messages == 0 ? m.log_time : std::min(s.first, m.log_time);
        s.last = s.messages == 0 ? m.log_time : std::max(s.last, m.log_time);
        ++s.messages;
        ++s.messages_of[m.channel->id];
        if (!entry) entry = IndexEntry{record.at, m.log_time, m.log_time};
        entry->first = std::min(entry->first, m.log_time);
        entry->last = std::max(entry->last, m.log_time);
        return true;
      });
      if (record.opcode == Opcode::metadata) take_metadata(record.content);
      if (record.opcode == Opcode::chunk) ++s.chunks;
      if (entry) index_.entries.push_back(*entry);
      return true;
    });
    return messages.undescribed();
  }

  const Source& source_;
  const std::string& name_;
  const McapReadOptions& options_;
  Index index_;
};

}  // namespace
}  // namespace mcap

using mcap::Opcode;
using mcap::Record;

namespace {

bool matches(const McapQuery& query, const McapMessage& m) {
  return m.log_time >= query.from && m.log_time <= query.until &&
         (query.topics.empty() || query.topics.contains(m.channel->topic));
}

struct PendingMessage {
  McapMessage message;
  std::uint64_t at = 0, nth = 0;  ///< position of its chunk or record, and its number in it
  std::shared_ptr<const std::string> bytes;  ///< to which the message refers

  bool operator<(const PendingMessage& other) const {  // the first to be delivered is the largest
    return std::tuple(message.log_time, at, nth) >
           std::tuple(other.message.log_time, other.at, other.nth);
  }
};

}  // namespace

struct McapReader::Impl {
  std::unique_ptr<Source> source;
  std::string name;
  McapReadOptions options;
  mcap::Index index = {};

  void read_through(const McapQuery& query, const mcap::Messages::Sink& sink,
                    Problems& problems) const {
    mcap::Description description = index.known;
    mcap::Messages messages(description, name, options, problems);
    mcap::Walk walk(*source, name, options, problems);
    walk.run([&](const Record& record) {
      // Not protected by a checksum: one flipped bit makes a message of an index.
      if (index.contents.indexed && record.opcode == Opcode::message) {
        problems.add(fault_at(
            record.at, "a message outside of the chunks, unknown to the summary; skipped", name));
        return true;
      }
      return messages.take(record,
                           [&](const McapMessage& m) { return !matches(query, m) || sink(m); });
    });
  }

  void read_by_time(const McapQuery& query, const mcap::Messages::Sink& sink,
                    Problems& problems) const {
    mcap::Description description = index.known;
    mcap::Messages messages(description, name, options, problems);
    std::priority_queue<PendingMessage> pending;
    const auto deliver_before = [&](const LogTime* limit) {
      while (!pending.empty() && (limit == nullptr || pending.top().message.log_time < *limit)) {
        if (!sink(pending.top().message)) return false;
        pending.pop();
      }
      return true;
    };
    for (const mcap::IndexEntry& entry : index.entries) {
      if (entry.last < query.from || entry.first > query.until) continue;
      if (!deliver_before(&entry.first)) return;
      auto bytes = std::make_shared<std::string>();
      const auto record = fetch_entry(entry, *bytes);
      if (!record) {
        problems.add(fault_at(entry.at, "an index entry refers to no chunk", name));
        continue;
      }
      std::uint64_t nth = 0;
      messages.take(*record, [&](const McapMessage& m) {
        const auto& holder = messages.unpacked();
        if (matches(query, m)) pending.push({m, entry.at, nth, holder ? holder : bytes});
        ++nth;
        return true;
      });
    }
    deliver_before(nullptr);
  }

  [[nodiscard]] std::optional<Record> fetch_entry(const mcap::IndexEntry& entry,
                                                  std::string& buffer) const {
    for (const Opcode opcode : {Opcode::chunk, Opcode::message})
      if (const auto content = mcap::content_at(*source, entry.at, opcode, options, buffer))
        return Record{opcode, entry.at, *content};
    return std::nullopt;
  }
};

Result<McapReader> McapReader::from(std::shared_ptr<Impl> impl) {
  std::string buffer;
  if (impl->source->fetch(0, mcap::kMagic.size(), buffer) != mcap::kMagic)
    return Error{ErrorCode::parse, "does not begin as an MCAP recording does", impl->name};
  impl->index = mcap::Indexer(*impl->source, impl->name, impl->options).run();
  return McapReader(std::move(impl));
}

Result<McapReader> McapReader::open(const std::string& path, const McapReadOptions& options) {
  auto source = Source::open(path);
  if (!source) return source.error();
  return from(std::make_shared<Impl>(Impl{std::move(*source), path, options}));
}

Result<McapReader> McapReader::parse(std::string bytes, const std::string& source,
                                     const McapReadOptions& options) {
  return from(
      std::make_shared<Impl>(Impl{std::make_unique<Source>(std::move(bytes)), source, options}));
}

const McapContents& McapReader::contents() const { return impl_->index.contents; }

Problems McapReader::read(const McapQuery& query,
                          const std::function<bool(const McapMessage&)>& sink) const {
  Problems problems(impl_->options.max_problems);
  query.order == McapOrder::file ? impl_->read_through(query, sink, problems)
                                 : impl_->read_by_time(query, sink, problems);
  return problems;
}

}  // namespace wayfare::io
