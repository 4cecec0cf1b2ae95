#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include <wayfare/io/bag.hpp>
#include <wayfare/io/mcap.hpp>
#include <wayfare/ros/convert.hpp>
#include <wayfare/ros/recording.hpp>

#include "ros/recording/description.hpp"

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
    if (topics.contains(topic.name)) wanted[topic.name] = &topic;
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

/// One of the two is set.
struct RecordingWriter::Impl {
  std::string path;
  io::WriteOptions options;
  std::optional<io::BagWriter> bag;
  std::optional<io::McapWriter> mcap;
  std::string bytes;    ///< of a bag that could not be written yet
  bool closed = false;  ///< the bag
  struct Channel {
    std::uint32_t id = 0;
    std::string type;
  };
  std::map<std::string, Channel> channels;
};

namespace {

/// Sent once, for all who come later: transforms that do not change, the robot description.
bool is_latched(const std::string& topic, const MessageType& type) {
  return topic == "/tf_static" || type.name == String::kType.name;
}

}  // namespace

RecordingWriter::RecordingWriter(detail::Owned<Impl> impl) : impl_(std::move(impl)) {}

Result<RecordingWriter> RecordingWriter::create(const std::string& path,
                                                const io::WriteOptions& options) {
  auto impl = detail::make_owned<Impl>();
  impl->path = path;
  impl->options = options;
  if (path.ends_with(".bag")) {
    std::error_code ignored;
    if (options.existing == io::Existing::refuse && std::filesystem::is_regular_file(path, ignored))
      return Error{ErrorCode::io, "exists already; not overwritten", path};
    impl->bag.emplace();
  } else if (path.ends_with(".mcap")) {
    io::McapWriterOptions mcap;
    mcap.profile = "ros2";
    auto writer = io::McapWriter::create(path, mcap, options);
    if (!writer) return writer.error();
    impl->mcap = *std::move(writer);
  } else {
    return Error{ErrorCode::invalid, "ends neither in .mcap nor in .bag", path};
  }
  return RecordingWriter(std::move(impl));
}

Dialect RecordingWriter::dialect() const { return impl_->bag ? Dialect::ros1 : Dialect::ros2; }

bool RecordingWriter::knows(const std::string& topic, const MessageType& type) const {
  const auto found = impl_->channels.find(topic);
  return found != impl_->channels.end() && found->second.type == type.name;
}

Result<void> RecordingWriter::add(const std::string& topic, const MessageType& type,
                                  const std::string& definition, const io::McapMetadata& metadata) {
  if (const auto found = impl_->channels.find(topic); found != impl_->channels.end())
    return Error{ErrorCode::invalid,
                 "has messages of " + found->second.type + ", not of " + std::string(type.name),
                 topic};
  const std::string name(type.name);
  if (impl_->bag) {
    impl_->channels[topic] = {impl_->bag->add_connection({0, topic, name, std::string(type.md5),
                                                          definition, is_latched(topic, type)}),
                              name};
    return {};
  }
  const auto schema = impl_->mcap->add_schema(ros2_name(type.name),
                                              definition.empty() ? "" : "ros2msg", definition);
  if (!schema) return schema.error();
  const auto channel = impl_->mcap->add_channel(topic, "cdr", *schema, metadata);
  if (!channel) return channel.error();
  impl_->channels[topic] = {*channel, name};
  return {};
}

Result<void> RecordingWriter::write_bytes(const std::string& topic, LogTime received,
                                          std::string_view data) {
  const std::uint32_t channel = impl_->channels[topic].id;
  if (impl_->bag) return impl_->bag->write(channel, received, data);
  return impl_->mcap->write(static_cast<std::uint16_t>(channel), received, received, data);
}

Result<void> RecordingWriter::write_received(const ReceivedTopic& topic, LogTime received,
                                             std::string_view cdr) {
  if (impl_->bag)
    return Error{ErrorCode::invalid, "is a bag of ROS 1, without messages in CDR", impl_->path};
  const MessageType type{topic.type};
  if (!knows(topic.name, type))
    if (auto added = add(topic.name, type, topic.definition, topic.metadata); !added) return added;
  return write_bytes(topic.name, received, cdr);
}

Result<void> RecordingWriter::close() {
  if (impl_->mcap) return impl_->mcap->close();
  if (impl_->closed) return Error{ErrorCode::invalid, "the recording is closed", impl_->path};
  if (impl_->bytes.empty()) impl_->bytes = impl_->bag->finish();
  auto done = io::write_file(impl_->path, impl_->bytes, impl_->options);
  if (done) impl_->bytes.clear();
  impl_->closed = done.has_value();
  return done;
}

namespace {

/// A sum rounded once, not with every term (Kahan).
class Sum {
 public:
  double add(double term) {
    const double corrected = term + rest_, before = total_;
    total_ += corrected;
    rest_ = corrected - (total_ - before);
    return total_;
  }

 private:
  double total_ = 0.0, rest_ = 0.0;
};

/// The streams of a recording as messages, earliest first.
class RobotWriter {
 public:
  RobotWriter(RecordingWriter& writer, const Recording& recording, const RobotTopics& topics,
              const UnitRun& unit)
      : writer_(writer),
        recording_(recording),
        topics_(topics),
        unit_(unit),
        gyro_(unit.samples.empty() ? std::span(recording.gyro) : std::span<const GyroSample>()) {}

  /// At equal times in the order of the streams here.
  Result<void> run() {
    const Recording& r = recording_;
    const auto next_of = [](const auto& stream, std::size_t i) {
      return i < stream.size() ? &stream[i].time : nullptr;
    };
    for (std::size_t odometry = 0, scan = 0, radar = 0, gyro = 0, truth = 0, unit = 0, wheel = 0;
         ;) {
      const LogTime* const times[] = {next_of(r.odometry, odometry), next_of(r.scans, scan),
                                      next_of(r.radar, radar),       next_of(gyro_, gyro),
                                      next_of(r.truth, truth),       next_of(unit_.samples, unit),
                                      next_of(r.wheels, wheel)};
      const LogTime* next = nullptr;
      for (const LogTime* time : times)
        if (time != nullptr && (next == nullptr || *time < *next)) next = time;
      if (next == nullptr) return {};
      if (*next <= LogTime())
        return Error{ErrorCode::invalid, "has a time of zero or before: ROS takes that as not set"};
      if (*next >= kEnd)
        return Error{ErrorCode::invalid, "has a time after 2038, which ROS 2 does not represent"};
      auto done = write_mountings(*next);
      if (done)
        done = next == times[0]   ? write(r.odometry[odometry++])
               : next == times[1] ? write(r.scans[scan++], topics_.scan, topics_.laser_frame)
               : next == times[2] ? write(r.radar[radar++], topics_.radar, topics_.radar_frame)
               : next == times[3] ? write(gyro_[gyro++], topics_.imu, topics_.imu_frame)
               : next == times[4] ? write(r.truth[truth++], topics_.truth, topics_.map_frame)
               : next == times[5] ? write(unit_.samples[unit++])
                                  : write(r.wheels[wheel++]);
      if (!done) return done;
    }
  }

 private:
  /// Stamps of ROS 2 have signed seconds of 32 bits; those of ROS 1 would last to 2106.
  static constexpr LogTime kEnd = LogTime::from_nanoseconds((1LL << 31) * 1'000'000'000);

  /// Once, before everything else.
  Result<void> write_mountings(LogTime time) {
    if (std::exchange(mounted_, true)) return {};
    TfMessage message;
    const auto add = [&](const SE2d& pose, const std::string& frame) {
      message.transforms.push_back(transform_of(pose, time, topics_.base_frame, frame));
    };
    if (!recording_.scans.empty()) add(recording_.T_base_laser.raw(), topics_.laser_frame);
    if (!recording_.radar.empty()) add(recording_.T_base_radar.raw(), topics_.radar_frame);
    if (!gyro_.empty() || !unit_.samples.empty()) add(unit_.T_base_unit, topics_.imu_frame);
    auto done = writer_.write("/tf_static", time, message);
    const std::string description = urdf_of(recording_, topics_);
    if (!done || description.empty()) return done;
    return writer_.write(topics_.description, time, String{description});
  }
  /// Positions are sums of the distances, rounded once.
  Result<void> write(const WheelSample& sample) {
    if (!std::isfinite(sample.left_m) || !std::isfinite(sample.right_m)) return {};
    JointState message;
    message.header = header_of(sample.time, "");
    message.name = {topics_.left_wheel, topics_.right_wheel};
    message.position = {left_m_.add(sample.left_m) / topics_.wheel_radius_m,
                        right_m_.add(sample.right_m) / topics_.wheel_radius_m};
    return writer_.write(topics_.joints, sample.time, message);
  }
  Result<void> write(const OdometrySample& sample) {
    const SE2d pose = sample.T_odom_base.raw();
    const Odometry message = message_of(sample, topics_.odom_frame, topics_.base_frame);
    if (auto done = writer_.write(topics_.odometry, sample.time, message); !done) return done;
    return writer_.write(
        "/tf", sample.time,
        TfMessage{{transform_of(pose, sample.time, topics_.odom_frame, topics_.base_frame)}});
  }
  Result<void> write(const MargSample& s) {
    if (s.angular_rate_radps.allFinite() && s.specific_force_mps2.allFinite()) {
      const ImuSample sample{s.time, s.angular_rate_radps, s.specific_force_mps2};
      if (auto done = write(sample, topics_.imu, topics_.imu_frame); !done) return done;
    }
    if (!s.magnetic_field_uT.allFinite()) return {};
    return writer_.write(topics_.magnetometer, s.time,
                         magnetic_message_of(s.magnetic_field_uT, s.time, topics_.imu_frame));
  }
  template <class Measurement>
  Result<void> write(const Measurement& m, const std::string& topic, const std::string& frame) {
    return writer_.write(topic, m.time, message_of(m, frame));
  }

  RecordingWriter& writer_;
  const Recording& recording_;
  const RobotTopics& topics_;
  const UnitRun& unit_;
  std::span<const GyroSample> gyro_;
  Sum left_m_, right_m_;
  bool mounted_ = false;
};

}  // namespace

Result<void> write_robot(RecordingWriter& writer, const Recording& recording,
                         const RobotTopics& topics, const UnitRun& unit) {
  return RobotWriter(writer, recording, topics, unit).run();
}

}  // namespace wayfare::ros
