#include "rosbag2_metadata.hpp"

#include <sstream>

namespace wayfare::examples {
namespace {

/// In double quotes, with the escapes of YAML.
std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c == '\n' ? "\\n" : std::string(1, c);
  }
  return out + "\"";
}

}  // namespace

std::string offered_qos_profile(const ros::Qos& qos) {
  const auto never = [](const char* name) {
    return std::string("  ") + name + ":\n    sec: 9223372036\n    nsec: 854775807\n";
  };
  std::ostringstream out;
  out << "- history: 1\n  depth: " << qos.depth
      << "\n  reliability: " << (qos.reliability == ros::Reliability::reliable ? 1 : 2)
      << "\n  durability: " << (qos.durability == ros::Durability::transient_local ? 1 : 2) << "\n"
      << never("deadline") << never("lifespan") << "  liveliness: 1\n"
      << never("liveliness_lease_duration") << "  avoid_ros_namespace_conventions: false";
  return out.str();
}

std::string rosbag2_metadata(const std::string& file, const std::vector<RecordedTopic>& topics,
                             LogTime first, LogTime last) {
  std::uint64_t messages = 0;
  for (const RecordedTopic& t : topics) messages += t.messages;
  const auto duration_ns = (last - first).count();
  std::ostringstream out;
  out << "rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: mcap\n"
      << "  duration:\n    nanoseconds: " << duration_ns << "\n"
      << "  starting_time:\n    nanoseconds_since_epoch: " << first.nanoseconds() << "\n"
      << "  message_count: " << messages
      << "\n  topics_with_message_count:" << (topics.empty() ? " []\n" : "\n");
  for (const RecordedTopic& t : topics)
    out << "    - topic_metadata:\n        name: " << t.name << "\n        type: " << t.type
        << "\n        serialization_format: cdr\n        offered_qos_profiles: " << quoted(t.qos)
        << "\n      message_count: " << t.messages << "\n";
  out << "  compression_format: \"\"\n  compression_mode: \"\"\n"
      << "  relative_file_paths:\n    - " << file << "\n"
      << "  files:\n    - path: " << file << "\n      starting_time:\n"
      << "        nanoseconds_since_epoch: " << first.nanoseconds() << "\n      duration:\n"
      << "        nanoseconds: " << duration_ns << "\n      message_count: " << messages << "\n";
  return out.str();
}

}  // namespace wayfare::examples
