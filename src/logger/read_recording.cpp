#include <algorithm>

#include <wayfare/io/mcap.hpp>
#include <wayfare/logger/messages.hpp>

namespace wayfare::logger {
namespace {

/// Topics with that schema, in the order of their channels.
std::vector<std::string> topics_of(const io::McapContents& contents, std::string_view schema) {
  std::vector<std::string> topics;
  for (const io::McapChannel& channel : contents.channels)
    for (const io::McapSchema& s : contents.schemas)
      if (s.id == channel.schema && s.name == schema && channel.message_encoding == "json")
        topics.push_back(channel.topic);
  return topics;
}

/// All messages of a topic that `parse` accepts, in order of their measurement times.
template <class Measurement, class Parse>
std::vector<Measurement> read_topic(const io::McapReader& reader, const std::string& topic,
                                    Parse parse, io::Problems& problems) {
  std::vector<Measurement> all;
  io::Problems met = reader.read({io::McapOrder::file, {topic}}, [&](const io::McapMessage& m) {
    auto measurement = parse(m.data);
    if (measurement) {
      all.push_back(std::move(*measurement));
    } else {
      problems.add({ErrorCode::parse, measurement.error().message, topic, m.sequence + 1U, 0});
    }
    return true;
  });
  for (const Error& error : met.first()) problems.add(error);
  std::stable_sort(all.begin(), all.end(),
                   [](const Measurement& a, const Measurement& b) { return a.time < b.time; });
  return all;
}

}  // namespace

bool is_recording(const std::string& path) {
  constexpr std::string_view kEnd = ".mcap";
  return path.size() > kEnd.size() && path.ends_with(kEnd);
}

Result<RecordedMarg> read_marg_recording(const std::string& path, const std::string& topic) {
  const auto reader = io::McapReader::open(path);
  if (!reader) return reader.error();
  const std::vector<std::string> topics = topics_of(reader->contents(), imu_schema().name);
  std::string named;
  for (const std::string& t : topics) named += (named.empty() ? "" : ", ") + t;
  if (topics.empty())
    return Error{ErrorCode::not_found, "holds no inertial unit (wayfare.Imu)", path};
  if (topic.empty() && topics.size() > 1)
    return Error{ErrorCode::invalid, "holds several units, name one topic: " + named, path};
  if (!topic.empty() && std::find(topics.begin(), topics.end(), topic) == topics.end())
    return Error{ErrorCode::not_found, "holds no unit " + topic + "; there are " + named, path};
  RecordedMarg out;
  out.problems = reader->contents().problems;
  out.topic = topic.empty() ? topics.front() : topic;
  out.samples = read_topic<MargSample>(*reader, out.topic, parse_imu, out.problems);
  return out;
}

Result<RecordedRobot> read_robot_recording(const std::string& path) {
  const auto reader = io::McapReader::open(path);
  if (!reader) return reader.error();
  RecordedRobot out;
  out.problems = reader->contents().problems;
  const auto scans = topics_of(reader->contents(), laser_scan_schema().name);
  const auto radars = topics_of(reader->contents(), point_cloud_schema().name);
  if (scans.empty() && radars.empty())
    return Error{ErrorCode::not_found, "holds no laser scan and no radar points", path};
  if (!scans.empty()) {
    out.scan_topic = scans.front();
    out.recording.scans =
        read_topic<LaserScan>(*reader, out.scan_topic, parse_laser_scan, out.problems);
  }
  if (!radars.empty()) {
    out.radar_topic = radars.front();
    out.recording.radar =
        read_topic<RadarScan>(*reader, out.radar_topic, parse_point_cloud, out.problems);
  }
  return out;
}

}  // namespace wayfare::logger
