#include <wayfare/io/mcap.hpp>

#include <queue>
#include <tuple>
#include <utility>

#include "io/recording/mcap_walk.hpp"

namespace wayfare::io {

using mcap::Opcode;
using mcap::Record;

namespace {

bool matches(const McapQuery& query, const McapMessage& m) {
  return m.log_time >= query.from && m.log_time <= query.until &&
         (query.topics.empty() || query.topics.count(m.channel->topic) != 0);
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
  impl->index = mcap::make_index(*impl->source, impl->name, impl->options);
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
  if (query.order == McapOrder::file) {
    impl_->read_through(query, sink, problems);
  } else {
    impl_->read_by_time(query, sink, problems);
  }
  return problems;
}

}  // namespace wayfare::io
