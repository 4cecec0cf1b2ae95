#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include <wayfare/io/bag.hpp>
#include <wayfare/io/mcap.hpp>
#include <wayfare/ros/recording.hpp>

namespace wayfare::ros {
namespace {

bool is_bag(std::string_view path) { return path.ends_with(".bag") || path.ends_with(".bag.gz"); }

/// The topics of an MCAP file that hold ROS messages.
std::vector<Topic> topics_of(const io::McapContents& contents) {
  std::vector<Topic> topics;
  for (const io::McapChannel& channel : contents.channels) {
    const bool cdr = channel.message_encoding == "cdr";
    if (!cdr && channel.message_encoding != "ros1") continue;
    for (const io::McapSchema& schema : contents.schemas)
      if (schema.id == channel.schema)
        topics.push_back(
            {channel.topic, ros1_name(schema.name), cdr ? Dialect::ros2 : Dialect::ros1});
  }
  return topics;
}

std::vector<Topic> topics_of(const io::BagContents& contents) {
  std::vector<Topic> topics;
  for (const io::BagConnection& c : contents.connections)
    topics.push_back({c.topic, c.type, Dialect::ros1});
  return topics;
}

}  // namespace

/// One of the two is set.
struct RecordingFile::Reader {
  std::optional<io::BagReader> bag;
  std::optional<io::McapReader> mcap;
};

bool RecordingFile::is_one(const std::string& path) {
  if (is_bag(path)) return true;
  if (!path.ends_with(".mcap")) return false;
  const auto mcap = io::McapReader::open(path);
  return mcap && !topics_of(mcap->contents()).empty();
}

Result<RecordingFile> RecordingFile::open(const std::string& path) {
  auto reader = std::make_shared<Reader>();
  RecordingFile file;
  file.path_ = path;
  if (is_bag(path)) {
    auto bag = io::BagReader::open(path);
    if (!bag) return bag.error();
    file.topics_ = topics_of(bag->contents());
    file.problems_ = bag->contents().problems;
    reader->bag = *std::move(bag);
  } else {
    auto mcap = io::McapReader::open(path);
    if (!mcap) return mcap.error();
    file.topics_ = topics_of(mcap->contents());
    file.problems_ = mcap->contents().problems;
    reader->mcap = *std::move(mcap);
  }
  // Several publishers of a topic are merged.
  auto& topics = file.topics_;
  const auto before = [](const Topic& a, const Topic& b) { return a.name < b.name; };
  std::stable_sort(topics.begin(), topics.end(), before);
  const auto same = [](const Topic& a, const Topic& b) { return a.name == b.name; };
  topics.erase(std::unique(topics.begin(), topics.end(), same), topics.end());
  file.reader_ = std::move(reader);
  return file;
}

io::Problems RecordingFile::read(const std::set<std::string>& topics,
                                 const std::function<bool(const RecordedMessage&)>& sink) const {
  std::map<std::string_view, const Topic*> wanted;
  for (const Topic& topic : topics_)
    if (topics.count(topic.name) != 0) wanted[topic.name] = &topic;
  if (reader_->bag)
    return reader_->bag->read([&](const io::BagMessage& m) {
      const auto topic = wanted.find(m.connection->topic);
      return topic == wanted.end() || sink({*topic->second, m.time, m.data});
    });
  return reader_->mcap->read({io::McapOrder::file, topics}, [&](const io::McapMessage& m) {
    const auto topic = wanted.find(m.channel->topic);
    return topic == wanted.end() || sink({*topic->second, m.log_time, m.data});
  });
}

}  // namespace wayfare::ros
