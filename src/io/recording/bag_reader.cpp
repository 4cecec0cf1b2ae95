#include <wayfare/io/bag.hpp>

#include <utility>

#include "io/recording/bag_walk.hpp"

namespace wayfare::io {

struct BagReader::Impl {
  std::unique_ptr<Source> source;
  std::string name;
  BagReadOptions options;
  BagContents contents;
  bag::Connections known;

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
        known.emplace(c->id, *std::move(c));
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
      contents.problems.add({ErrorCode::parse,
                             "the bag was not closed, or its index is damaged; read from the "
                             "front instead",
                             name, 0, static_cast<std::size_t>(source->size())});
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

BagReader::BagReader(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
BagReader::BagReader(BagReader&&) noexcept = default;
BagReader& BagReader::operator=(BagReader&&) noexcept = default;
BagReader::~BagReader() = default;

Result<BagReader> BagReader::from(std::unique_ptr<Impl> impl) {
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
  auto impl = std::make_unique<Impl>();
  impl->source = std::move(*source);
  impl->name = path;
  impl->options = options;
  return from(std::move(impl));
}

Result<BagReader> BagReader::parse(std::string bytes, const std::string& source,
                                   const BagReadOptions& options) {
  auto impl = std::make_unique<Impl>();
  impl->source = std::make_unique<Source>(std::move(bytes));
  impl->name = source;
  impl->options = options;
  return from(std::move(impl));
}

const BagContents& BagReader::contents() const { return impl_->contents; }

Problems BagReader::read(const std::function<bool(const BagMessage&)>& sink) const {
  Problems problems(impl_->options.max_problems);
  bag::Connections known = impl_->known;
  bag::Walk(*impl_->source, impl_->name, impl_->options, known, problems).run(sink);
  return problems;
}

}  // namespace wayfare::io
