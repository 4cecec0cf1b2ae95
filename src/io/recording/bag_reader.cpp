#include <wayfare/io/bag.hpp>

#include <algorithm>
#include <functional>
#include <map>
#include <utility>

#include "io/recording/bag_records.hpp"

namespace wayfare::io {
namespace bag {
namespace {

constexpr std::size_t kLongestHead = 1U << 20U;  // of a record; definitions are in its data

using Connections = std::map<std::uint32_t, BagConnection>;
using Sink = std::function<bool(const BagMessage&)>;

/// Iterates over the records and skips damaged parts.
class Walk {
 public:
  Walk(const Source& source, const std::string& name, const BagReadOptions& options,
       Connections& known, Problems& problems)
      : source_(source), name_(name), options_(options), known_(known), problems_(problems) {}

  void run(const Sink& sink) {
    std::uint64_t at = kMagic.size();
    while (at < source_.size()) {
      std::uint64_t size = 0;
      const auto record = record_at(at, size);
      if (!record) {
        const std::uint64_t next = next_chunk(at + 1);
        fault(at, next == source_.size()
                      ? "the bag is cut off or damaged here; " + std::to_string(next - at) +
                            " bytes at its end are skipped"
                      : "is damaged here; reading continues with the chunk at byte " +
                            std::to_string(next));
        at = next;
        continue;
      }
      if (!take(*record, at, sink)) return;
      at += size;
    }
  }

  /// Number of messages skipped because their connection was not described before.
  [[nodiscard]] std::size_t undescribed() const { return undescribed_; }

  /// The record at `at` and its length; nullopt where there is none, or it is too large.
  std::optional<Record> record_at(std::uint64_t at, std::uint64_t& size) {
    const auto length = number_at(at);
    if (!length || *length > kLongestHead) return std::nullopt;
    const auto data = number_at(at + 4 + *length);
    if (!data || *data > options_.max_record_bytes) return std::nullopt;
    size = 8 + std::uint64_t{*length} + *data;
    const auto bytes = source_.fetch(at, size, buffer_);
    if (!bytes) return std::nullopt;
    std::string_view rest = *bytes;
    return take_record(rest);
  }

 private:
  std::optional<std::uint32_t> number_at(std::uint64_t at) {
    const auto bytes = source_.fetch(at, 4, buffer_);
    if (!bytes) return std::nullopt;
    return ByteCursor(*bytes).number<std::uint32_t>();
  }

  /// The position of the next chunk: that of its header's length.
  std::uint64_t next_chunk(std::uint64_t from) {
    constexpr std::string_view kOp{"\4\0\0\0op=\5", 8};
    constexpr std::uint64_t kWindow = 1U << 16U, kHead = 64;  // longest header of a chunk
    std::string window;
    for (std::uint64_t at = from; at < source_.size(); at += kWindow) {
      const std::uint64_t n = std::min(source_.size() - at, kWindow + kHead);
      const auto bytes = source_.fetch(at, n, window);
      if (!bytes) break;
      for (std::size_t i = bytes->find(kOp); i != std::string_view::npos;
           i = bytes->find(kOp, i + 1))
        for (std::uint64_t back = 4; back <= kHead && back <= at + i - from; ++back)
          if (is_chunk(at + i - back)) return at + i - back;
    }
    return source_.size();
  }

  bool is_chunk(std::uint64_t at) {
    const auto length = number_at(at);
    if (!length || *length > 64) return false;
    const auto head = source_.fetch(at + 4, *length, buffer_);
    const auto fields = head ? Fields::parse(*head) : std::nullopt;
    if (!fields || fields->number<std::uint8_t>("op") != std::uint8_t{5} ||
        !fields->number<std::uint32_t>("size") || fields->text("compression").empty())
      return false;
    const auto data = number_at(at + 4 + *length);
    return data && *data <= source_.size() - at - 8 - *length;
  }

  bool take(const Record& record, std::uint64_t at, const Sink& sink) {
    if (record.op == Op::chunk) return take_chunk(record, at, sink);
    if (record.op == Op::message) return take_message(record, at, sink);
    if (record.op != Op::connection) return true;
    auto c = connection_of(record);
    if (!c) return fault(at, "a connection is malformed; skipped");
    const std::uint32_t id = c->id;
    known_.emplace(id, *std::move(c));
    return true;
  }

  bool take_message(const Record& record, std::uint64_t at, const Sink& sink) {
    const auto id = record.fields.number<std::uint32_t>("conn");
    const auto time = record.fields.time("time");
    if (!id || !time) return fault(at, "a message is malformed; skipped");
    const auto connection = known_.find(*id);
    if (connection == known_.end()) {
      ++undescribed_;
      return fault(at, "a message of connection " + std::to_string(*id) +
                           ", which was not described; skipped");
    }
    return sink({&connection->second, *time, record.data});
  }

  bool take_chunk(const Record& record, std::uint64_t at, const Sink& sink) {
    const auto size = record.fields.number<std::uint32_t>("size");
    const std::string_view compression = record.fields.text("compression");
    std::string_view rest = record.data;
    std::string unpacked;
    if (!size || *size > options_.max_record_bytes)
      return fault(at, "a chunk has no size or is too large; skipped");
    if (compression != "none") {
      auto done = decompress_block(compression, rest, *size);
      if (!done) return fault(at, "a chunk " + done.error().message, done.error().code);
      unpacked = *std::move(done);
      rest = unpacked;
    }
    while (!rest.empty()) {
      const auto inner = take_record(rest);
      if (!inner || inner->op == Op::chunk)
        return fault(at, "the rest of a chunk is malformed; skipped");
      if (!take(*inner, at, sink)) return false;
    }
    return true;
  }

  /// Returns true: reading continues after the fault.
  bool fault(std::uint64_t at, std::string message, ErrorCode code = ErrorCode::parse) {
    problems_.add(fault_at(at, std::move(message), name_, code));
    return true;
  }

  const Source& source_;
  const std::string& name_;
  const BagReadOptions& options_;
  Connections& known_;
  Problems& problems_;
  std::string buffer_;
  std::size_t undescribed_ = 0;
};

}  // namespace
}  // namespace bag

struct BagReader::Impl {
  std::unique_ptr<Source> source;
  std::string name;
  BagReadOptions options;
  BagContents contents = {};
  bag::Connections known = {};

  /// Reads connections and message count from the index at the end; false where it is inconsistent.
  bool read_index() {
    Problems ignored;
    bag::Walk walk(*source, name, options, known, ignored);
    std::uint64_t size = 0, at = bag::kMagic.size();
    const auto head = walk.record_at(at, size);
    if (!head || head->op != bag::Op::head) return false;
    at = head->fields.number<std::uint64_t>("index_pos").value_or(0);
    std::uint32_t connections = head->fields.number<std::uint32_t>("conn_count").value_or(0);
    std::uint32_t chunks = head->fields.number<std::uint32_t>("chunk_count").value_or(0);
    if (at == 0) return false;
    for (; at < source->size(); at += size) {
      const auto record = walk.record_at(at, size);
      if (!record) return false;
      if (record->op == bag::Op::connection) {
        auto c = bag::connection_of(*record);
        if (!c || connections-- == 0) return false;
        const std::uint32_t id = c->id;
        known.emplace(id, *std::move(c));
      } else if (record->op == bag::Op::chunk_info) {
        if (chunks-- == 0) return false;
        ByteCursor counts(record->data);
        while (!counts.at_end()) {
          counts.number<std::uint32_t>();
          contents.messages += counts.number<std::uint32_t>();
        }
        if (!counts.ok()) return false;
      }
    }
    return connections == 0 && chunks == 0;
  }

  /// Returns the number of messages of undescribed connections.
  std::size_t count_messages() {
    bag::Walk walk(*source, name, options, known, contents.problems);
    walk.run([&](const BagMessage&) {
      ++contents.messages;
      return true;
    });
    return walk.undescribed();
  }

  void find_contents() {
    contents.problems = Problems(options.max_problems);
    contents.bytes = source->size();
    contents.indexed = read_index();
    if (!contents.indexed) {
      known.clear();
      contents.messages = 0;
      contents.problems.add(fault_at(
          source->size(),
          "the bag was not closed, or its index is damaged; read from the front instead", name));
      const Problems before = contents.problems;
      // A damaged description may be repeated further on, at the latest at the end.
      if (count_messages() != 0) {
        contents.problems = before;
        contents.messages = 0;
        count_messages();
      }
    }
    for (const auto& [id, connection] : known) contents.connections.push_back(connection);
  }
};

Result<BagReader> BagReader::from(std::shared_ptr<Impl> impl) {
  std::string buffer;
  const auto magic = impl->source->fetch(0, bag::kMagic.size(), buffer);
  if (!magic || *magic != bag::kMagic) {
    const bool older = magic && magic->starts_with("#ROSBAG V");
    return Error{older ? ErrorCode::unsupported : ErrorCode::parse,
                 older ? "is a bag of another version than 2.0: `rosbag fix` converts it"
                       : "does not begin as a ROS 1 bag does",
                 impl->name};
  }
  impl->find_contents();
  return BagReader(std::move(impl));
}

Result<BagReader> BagReader::open(const std::string& path, const BagReadOptions& options) {
  auto source = Source::open(path);
  if (!source) return source.error();
  std::string buffer;
  if (const auto begin = (*source)->fetch(0, 2, buffer); begin && *begin == "\x1f\x8b") {
    auto content = read_file(path);
    if (!content) return content.error();
    return parse(std::move(content->bytes), path, options);
  }
  return from(std::make_shared<Impl>(Impl{std::move(*source), path, options}));
}

Result<BagReader> BagReader::parse(std::string bytes, const std::string& source,
                                   const BagReadOptions& options) {
  return from(
      std::make_shared<Impl>(Impl{std::make_unique<Source>(std::move(bytes)), source, options}));
}

const BagContents& BagReader::contents() const { return impl_->contents; }

Problems BagReader::read(const std::function<bool(const BagMessage&)>& sink) const {
  Problems problems(impl_->options.max_problems);
  bag::Connections known = impl_->known;
  bag::Walk(*impl_->source, impl_->name, impl_->options, known, problems).run(sink);
  return problems;
}

}  // namespace wayfare::io
