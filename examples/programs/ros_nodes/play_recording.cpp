// Plays a recording of ROS messages onto live topics, in real time or faster.

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <wayfare/ros/recording.hpp>

#include "known_messages.hpp"
#include "node_program.hpp"

namespace {

using namespace wayfare;
using examples::MessageKind;
using examples::steady_s;

struct Arguments {
  std::string recording;
  double speed = 1.0, from_s = 0.0, seconds = 1e9, wait_s = 30.0;
  std::vector<std::string> leave_out, wait_for;
};

/// Sent once, for all who come later.
bool is_latched(std::string_view topic) {
  return topic.ends_with("tf_static") || topic.ends_with("robot_description");
}

struct Channel {
  MessageKind kind;
  ros::RawPublisher publisher;
};

std::map<std::string, Channel> advertise(ros::Node& node, const ros::RecordingFile& file,
                                         const Arguments& a) {
  const auto& known = examples::known_messages();
  const std::set<std::string> left_out(a.leave_out.begin(), a.leave_out.end());
  std::map<std::string, Channel> channels;
  for (const ros::Topic& topic : file.topics()) {
    const auto kind = known.find(topic.type);
    if (left_out.contains(topic.name)) continue;
    if (kind == known.end()) {
      node.say(ros::Severity::warning,
               "left out '" + topic.name + "': its type " + topic.type + " is not known");
      continue;
    }
    channels[topic.name] = {
        kind->second,
        node.raw().advertise(topic.name, kind->second.type,
                             is_latched(topic.name) ? ros::Qos::latched() : ros::Qos())};
  }
  return channels;
}

/// Waits for subscribers to the topics of --wait-for.
Result<void> wait_for_listeners(ros::Node& node, const std::map<std::string, Channel>& channels,
                                const Arguments& a) {
  const double until_s = steady_s() + a.wait_s;
  for (const std::string& topic : a.wait_for) {
    const auto channel = channels.find(topic);
    if (channel == channels.end())
      return Error{ErrorCode::not_found, "is not a topic that is played", topic};
    while (node.ok() && channel->second.publisher.subscribers() == 0) {
      if (steady_s() > until_s) return Error{ErrorCode::not_found, "has no subscribers", topic};
      node.spin(0.02);
    }
  }
  return {};
}

Result<std::size_t> play(ros::Node& node, const ros::RecordingFile& file, const Arguments& a) {
  const auto channels = advertise(node, file, a);
  if (auto ok = wait_for_listeners(node, channels, a); !ok) return ok.error();
  std::set<std::string> topics;
  for (const auto& channel : channels) topics.insert(channel.first);
  std::size_t sent = 0;
  std::optional<LogTime> first;
  std::optional<Error> damaged;
  const double begin_s = steady_s();
  file.read(topics, [&](const ros::RecordedMessage& m) {
    if (!first) first = m.received;
    const double since_s = to_seconds(m.received - *first);
    const Channel& channel = channels.at(m.topic.name);
    // Static transforms are recorded only at the beginning.
    if (since_s < a.from_s && !is_latched(m.topic.name)) return true;
    if (since_s > a.from_s + a.seconds) return false;
    const double due_s = begin_s + (since_s - a.from_s) / a.speed;
    while (node.ok() && steady_s() < due_s) node.spin(std::min(0.05, due_s - steady_s()));
    auto bytes = channel.kind.convert(m.data, m.topic.dialect, node.dialect());
    if (!bytes) return damaged = bytes.error(), true;
    channel.publisher.publish(*bytes);
    ++sent;
    return node.ok();
  });
  if (damaged) node.say(ros::Severity::warning, "left out messages: " + damaged->to_string());
  // Queued messages are lost when the node ends.
  for (int i = 0; i < 20 && node.ok(); ++i) node.spin(0.05);
  return sent;
}

}  // namespace

int main(int argc, char** argv) {
  Arguments a;
  examples::CommandLine app(
      "Play a recording of ROS messages (.bag, or .mcap of ROS 2) onto its topics. "
      "Transforms on tf_static are latched.");
  app.add_file("RECORDING", a.recording, "the recording").required();
  app.add_number("--speed", a.speed, 1e-3, 1e6, "speed, times real time");
  app.add_option("--from-s", a.from_s, "seconds to skip at the beginning").not_negative();
  app.add_option("--seconds", a.seconds, "largest duration to play").positive();
  app.add_option("--leave-out", a.leave_out, "a topic to leave out; repeatable").take_all();
  app.add_option("--wait-for", a.wait_for,
                 "a topic that must have a subscriber before the first message; repeatable")
      .take_all();
  app.add_option("--wait-s", a.wait_s, "longest time to wait for subscribers")
      .not_negative()
      .show_default();
  app.example("robot.bag --speed 2", "twice as fast as recorded");
  const auto started = examples::start_node(argc, argv, "play_recording", app);
  if (!started.node) return started.exit_code;
  const auto file = ros::RecordingFile::open(a.recording);
  const auto sent = file ? play(*started.node, *file, a) : Result<std::size_t>(file.error());
  if (sent) {
    started.node->say(ros::Severity::info, std::to_string(*sent) + " messages sent");
    return 0;
  }
  started.node->say(ros::Severity::error, sent.error().to_string());
  return 1;
}
