#include <algorithm>
#include <queue>
#include <utility>

#include <wayfare/io/mcap_reader.hpp>

#include "mcap_walk.hpp"

namespace wayfare::io {

using mcap::Cursor;
using mcap::Opcode;
using mcap::Record;

namespace {

/// A chunk, or a message outside of chunks.
struct Place {
  std::uint64_t at = 0;
  LogTime first, last;
};

struct Description {
  std::map<std::uint16_t, McapSchema> schemas;
  std::map<std::uint16_t, McapChannel> channels;

  /// False where the record is malformed, or gives a known channel another topic.
  bool take(const Record& record) {
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
    const auto [there, fresh] = channels.emplace(n.id, n);
    return fresh || there->second.topic == n.topic;
  }
};

/// The parts of a message record; false where it is malformed.
bool read_message(std::string_view content, std::uint16_t& channel, McapMessage& message) {
  Cursor c(content);
  channel = c.number<std::uint16_t>();
  message.sequence = c.number<std::uint32_t>();
  message.log_time = c.time();
  message.publish_time = c.time();
  message.data = c.rest();
  return c.ok();
}

/// Messages out of records: schemas and channels are taken in as they come.
class Messages {
 public:
  using Sink = std::function<bool(const McapMessage&)>;

  Messages(Description& known, const std::string& name, Problems& problems)
      : known_(known), name_(name), problems_(problems) {}

  /// Messages left out because their channel was not described before them.
  [[nodiscard]] std::size_t undescribed() const { return undescribed_; }

  /// False once `sink` has had enough.
  bool take(const Record& record, const Sink& sink) {
    if (record.opcode == Opcode::chunk) return take_chunk(record, sink);
    if (record.opcode == Opcode::schema || record.opcode == Opcode::channel) {
      if (!known_.take(record)) fault(record.at, "a description is malformed or taken; left out");
      return true;
    }
    if (record.opcode != Opcode::message) return true;
    McapMessage message;
    std::uint16_t id = 0;
    if (!read_message(record.content, id, message)) {
      fault(record.at, "a message is malformed; left out");
      return true;
    }
    const auto channel = known_.channels.find(id);
    if (channel == known_.channels.end()) {
      ++undescribed_;
      fault(record.at,
            "a message of channel " + std::to_string(id) + ", which was not described; left out");
      return true;
    }
    message.channel = &channel->second;
    return sink(message);
  }

 private:
  bool take_chunk(const Record& record, const Sink& sink) {
    const mcap::ChunkHead chunk = mcap::read_chunk_head(record.content);
    if (auto wrong = mcap::fault_of(chunk, name_, record.at)) {
      problems_.add(std::move(*wrong));
      return true;
    }
    const std::uint64_t begin = record.at + record.bytes() - chunk.records.size();
    std::string_view rest = chunk.records;
    while (!rest.empty()) {
      const std::uint64_t at = begin + (chunk.records.size() - rest.size());
      const auto inner = mcap::take_record(rest, at);
      if (!inner || inner->opcode == Opcode::chunk) {
        fault(at, "the rest of a chunk is malformed; left out");
        return true;
      }
      if (!take(*inner, sink)) return false;
    }
    return true;
  }

  void fault(std::uint64_t at, std::string message) {
    problems_.add({ErrorCode::parse, std::move(message), name_, 0, static_cast<std::size_t>(at)});
  }

  Description& known_;
  const std::string& name_;
  Problems& problems_;
  std::size_t undescribed_ = 0;
};

}  // namespace

struct McapReader::Impl {
  std::unique_ptr<mcap::Source> source;
  std::string name;
  McapReadOptions options;
  McapContents contents;
  Description known;
  std::vector<Place> places;  ///< in order of their first time

  bool begins_well() {
    std::string buffer;
    const auto magic = source->fetch(0, mcap::kMagic.size(), buffer);
    return magic && *magic == mcap::kMagic;
  }

  [[nodiscard]] std::optional<std::string_view> record_at(std::uint64_t at, Opcode opcode,
                                                          std::string& buffer) const {
    const auto head = source->fetch(at, mcap::kRecordHead, buffer);
    if (!head) return std::nullopt;
    Cursor c(*head);
    const auto code = c.number<std::uint8_t>();
    const auto length = c.number<std::uint64_t>();
    if (code != static_cast<std::uint8_t>(opcode) || length > options.max_record_bytes)
      return std::nullopt;
    return source->fetch(at + mcap::kRecordHead, length, buffer);
  }

  void read_header() {
    std::string buffer;
    if (const auto content = record_at(mcap::kMagic.size(), Opcode::header, buffer)) {
      Cursor c(*content);
      contents.profile = c.text();
      contents.library = c.text();
    }
  }

  /// The summary's bytes with the footer up to its checksum, or why there are none.
  const char* find_summary(std::string& buffer, std::uint64_t& begin) const {
    constexpr std::uint64_t kFooter = mcap::kRecordHead + 20;
    const std::uint64_t tail = kFooter + mcap::kMagic.size();
    std::string end;
    const auto last = source->size() >= tail + mcap::kMagic.size()
                          ? source->fetch(source->size() - tail, tail, end)
                          : std::nullopt;
    if (!last || last->substr(kFooter) != mcap::kMagic ||
        (*last)[0] != static_cast<char>(Opcode::footer))
      return "was not closed, or its end is cut off";
    Cursor c(last->substr(mcap::kRecordHead));
    begin = c.number<std::uint64_t>();
    c.number<std::uint64_t>();
    const auto sum = c.number<std::uint32_t>();
    const std::uint64_t until = source->size() - tail + mcap::kRecordHead + 16;
    if (begin == 0) return "has no summary";
    if (begin < mcap::kMagic.size() || begin > until || until - begin > options.max_record_bytes)
      return "has a summary out of its bounds";
    const auto bytes = source->fetch(begin, until - begin, buffer);
    if (!bytes) return "has a summary that cannot be read";
    if (sum != 0 && mcap::crc(*bytes) != sum) return "has a summary with a wrong checksum";
    // The same bytes in both cases: of memory there is no copy yet.
    if (buffer.data() != bytes->data()) buffer = std::string(*bytes);
    return nullptr;
  }

  bool take_statistics(Cursor c, std::uint64_t& in_chunks) {
    McapStatistics& s = contents.statistics;
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
    if (c.ok()) contents.metadata[title] = std::move(pairs);
  }

  /// False where the summary does not hold together or leaves out how to find the messages.
  bool take_summary(std::string_view rest, std::uint64_t begin) {
    const std::size_t size = rest.size();
    bool counted = false;
    std::uint64_t chunks = 0;
    while (!rest.empty()) {
      const std::uint64_t at = begin + (size - rest.size());
      if (rest[0] == static_cast<char>(Opcode::footer)) break;
      const auto record = mcap::take_record(rest, at);
      if (!record) return false;
      Cursor c(record->content);
      if (record->opcode == Opcode::schema || record->opcode == Opcode::channel) {
        if (!known.take(*record)) return false;
      } else if (record->opcode == Opcode::chunk_index) {
        Place place;
        place.first = c.time();
        place.last = c.time();
        place.at = c.number<std::uint64_t>();
        if (!c.ok() || place.at < mcap::kMagic.size() || place.at >= begin) return false;
        places.push_back(place);
      } else if (record->opcode == Opcode::statistics) {
        if (!take_statistics(c, chunks)) return false;
        counted = true;
      } else if (record->opcode == Opcode::metadata_index) {
        std::string buffer;
        if (const auto content = record_at(c.number<std::uint64_t>(), Opcode::metadata, buffer))
          take_metadata(*content);
      }
    }
    // Messages outside of chunks have no index.
    return counted && chunks == places.size() && (chunks != 0 || contents.statistics.messages == 0);
  }

  void forget() {
    known = {};
    places.clear();
    contents.statistics = {};
    contents.metadata.clear();
  }

  /// Reads all of the data; gives how many messages were left out for want of a description.
  std::size_t scan() {
    Messages messages(known, name, contents.problems);
    mcap::Walk walk(*source, name, options, contents.problems);
    walk.run([&](const Record& record) {
      std::optional<Place> place;
      messages.take(record, [&](const McapMessage& m) {
        count(m);
        if (!place) place = Place{record.at, m.log_time, m.log_time};
        place->first = std::min(place->first, m.log_time);
        place->last = std::max(place->last, m.log_time);
        return true;
      });
      if (record.opcode == Opcode::metadata) take_metadata(record.content);
      if (record.opcode == Opcode::chunk) ++contents.statistics.chunks;
      if (place) places.push_back(*place);
      return true;
    });
    return messages.undescribed();
  }

  void count(const McapMessage& m) {
    McapStatistics& s = contents.statistics;
    s.first = s.messages == 0 ? m.log_time : std::min(s.first, m.log_time);
    s.last = s.messages == 0 ? m.log_time : std::max(s.last, m.log_time);
    ++s.messages;
    ++s.messages_of[m.channel->id];
  }

  void scan_all() {
    const Problems before = contents.problems;
    if (scan() == 0) return;
    // A description that was damaged may stand in a later chunk again.
    Description found = std::move(known);
    forget();
    known = std::move(found);
    contents.problems = before;
    scan();
  }

  void take_in() {
    contents.problems = Problems(options.max_problems);
    contents.bytes = source->size();
    read_header();
    std::string buffer;
    std::uint64_t begin = 0;
    const char* missing = find_summary(buffer, begin);
    if (missing == nullptr && !take_summary(buffer, begin)) {
      missing = "has a summary that does not lead to its messages";
    }
    contents.indexed = missing == nullptr;
    if (missing != nullptr) {
      forget();
      contents.problems.add(
          {ErrorCode::parse,
           std::string("the recording ") + missing + "; read from the front instead", name, 0,
           static_cast<std::size_t>(source->size())});
      scan_all();
    }
    for (const auto& [id, schema] : known.schemas) contents.schemas.push_back(schema);
    for (const auto& [id, channel] : known.channels) contents.channels.push_back(channel);
    std::stable_sort(places.begin(), places.end(),
                     [](const Place& a, const Place& b) { return a.first < b.first; });
  }

  static bool asked_for(const McapQuery& query, const McapMessage& m) {
    return m.log_time >= query.from && m.log_time <= query.until &&
           (query.topics.empty() || query.topics.count(m.channel->topic) != 0);
  }

  void read_through(const McapQuery& query, const Messages::Sink& sink, Problems& problems) const {
    Description description = known;
    Messages messages(description, name, problems);
    mcap::Walk walk(*source, name, options, problems);
    walk.run([&](const Record& record) {
      return messages.take(record,
                           [&](const McapMessage& m) { return !asked_for(query, m) || sink(m); });
    });
  }

  struct Waiting {
    McapMessage message;
    std::uint64_t order = 0;
    std::shared_ptr<const std::string> bytes;  ///< what the message refers to

    bool operator<(const Waiting& other) const {  // the first to be delivered is the largest
      return std::pair(message.log_time, order) > std::pair(other.message.log_time, other.order);
    }
  };

  void read_by_time(const McapQuery& query, const Messages::Sink& sink, Problems& problems) const {
    Description description = known;
    Messages messages(description, name, problems);
    std::priority_queue<Waiting> waiting;
    const auto deliver_before = [&](const LogTime* limit) {
      while (!waiting.empty() && (limit == nullptr || waiting.top().message.log_time < *limit)) {
        if (!sink(waiting.top().message)) return false;
        waiting.pop();
      }
      return true;
    };
    for (const Place& place : places) {
      if (place.last < query.from || place.first > query.until) continue;
      if (!deliver_before(&place.first)) return;
      auto bytes = std::make_shared<std::string>();
      const auto record = fetch_place(place, *bytes);
      if (!record) {
        problems.add({ErrorCode::parse, "an index leads to no chunk", name, 0,
                      static_cast<std::size_t>(place.at)});
        continue;
      }
      std::uint64_t order = place.at;
      messages.take(*record, [&](const McapMessage& m) {
        if (asked_for(query, m)) waiting.push({m, order, bytes});
        ++order;
        return true;
      });
    }
    deliver_before(nullptr);
  }

  [[nodiscard]] std::optional<Record> fetch_place(const Place& place, std::string& buffer) const {
    for (const Opcode opcode : {Opcode::chunk, Opcode::message})
      if (const auto content = record_at(place.at, opcode, buffer))
        return Record{opcode, place.at, *content};
    return std::nullopt;
  }
};

McapReader::McapReader(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
McapReader::McapReader(McapReader&&) noexcept = default;
McapReader& McapReader::operator=(McapReader&&) noexcept = default;
McapReader::~McapReader() = default;

Result<McapReader> McapReader::from(std::unique_ptr<Impl> impl) {
  if (!impl->begins_well())
    return Error{ErrorCode::parse, "does not begin as an MCAP recording does", impl->name};
  impl->take_in();
  return McapReader(std::move(impl));
}

Result<McapReader> McapReader::open(const std::string& path, const McapReadOptions& options) {
  auto source = mcap::Source::open(path);
  if (!source) return source.error();
  auto impl = std::make_unique<Impl>();
  impl->source = std::move(*source);
  impl->name = path;
  impl->options = options;
  return from(std::move(impl));
}

Result<McapReader> McapReader::parse(std::string bytes, const std::string& source,
                                     const McapReadOptions& options) {
  auto impl = std::make_unique<Impl>();
  impl->source = std::make_unique<mcap::Source>(std::move(bytes));
  impl->name = source;
  impl->options = options;
  return from(std::move(impl));
}

const McapContents& McapReader::contents() const { return impl_->contents; }

Problems McapReader::read(const McapQuery& query,
                          const std::function<bool(const McapMessage&)>& sink) const {
  Problems problems(impl_->options.max_problems);
  if (query.order == McapOrder::file) {
    impl_->read_through(query, sink, problems);
  } else {
    impl_->read_by_time(query, sink, problems);
  }
  return problems;
}

}  // namespace wayfare::io
