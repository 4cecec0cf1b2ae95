// Records live topics of any type, as `ros2 bag record` does.

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <wayfare/io/text_file.hpp>
#include <wayfare/ros/recording.hpp>

#include "known_messages.hpp"
#include "node_program.hpp"
#include "rosbag2_metadata.hpp"
#include "support/program_files.hpp"

namespace {

using namespace wayfare;
using examples::steady_s;

struct Arguments : examples::OutputArguments {
  std::vector<std::string> topics, leave_out;
  double seconds = 1e9;
};

/// Subscribes to topics as they appear and writes their messages as they arrive.
class Recorder {
 public:
  Recorder(ros::Node& node, ros::RecordingWriter writer, const Arguments& a)
      : node_(node),
        writer_(std::move(writer)),
        wanted_(a.topics.begin(), a.topics.end()),
        left_out_(a.leave_out.begin(), a.leave_out.end()) {}

  /// Topics that appeared since.
  void look() {
    for (const ros::PublishedTopic& topic : node_.raw().topics()) {
      if (left_out_.contains(topic.name) || (!wanted_.empty() && !wanted_.contains(topic.name)))
        continue;
      if (subscribed_.insert(topic.name).second) subscribe(topic);
    }
  }
  /// Errors: of the disk.
  [[nodiscard]] Result<void> run(double seconds) {
    const double end_s = steady_s() + seconds;
    for (double look_s = 0.0; node_.ok() && !failed_ && steady_s() < end_s;) {
      if (steady_s() >= look_s) look(), look_s = steady_s() + 0.5;
      node_.spin(0.05);
    }
    if (failed_) return *failed_;
    return writer_.close();
  }
  [[nodiscard]] std::string metadata(const std::string& file) const {
    std::vector<examples::RecordedTopic> topics;
    for (const auto& topic : topics_) topics.push_back(topic.second);
    return examples::rosbag2_metadata(file, topics, first_, last_);
  }
  /// What was recorded, and what was lost.
  void report() const {
    for (const auto& [name, topic] : topics_) {
      const std::uint64_t lost = subscriptions_.at(name).lost();
      node_.say(lost > 0 ? ros::Severity::warning : ros::Severity::info,
                name + ": " + std::to_string(topic.messages) + " messages" +
                    (lost > 0 ? ", " + std::to_string(lost) + " lost" : ""));
    }
  }

 private:
  void subscribe(const ros::PublishedTopic& topic) {
    const auto known = examples::known_messages().find(topic.type);
    const bool is_known = known != examples::known_messages().end();
    if (!is_known && node_.dialect() == ros::Dialect::ros1)
      return node_.say(ros::Severity::warning,
                       "leaves out '" + topic.name + "': its type " + topic.type + " is not known");
    const std::string type = ros::ros2_name(topic.type);
    node_.say(is_known ? ros::Severity::info : ros::Severity::warning,
              "records '" + topic.name + "', " + type +
                  (is_known ? "" : ", without a definition: the type is not known"));
    const std::string qos = examples::offered_qos_profile(topic.qos);
    topics_[topic.name] = {topic.name, type, qos, 0};
    ros::ReceivedTopic received{topic.name,
                                topic.type,
                                is_known ? known->second.definition : std::string(),
                                {{"offered_qos_profiles", qos}}};
    if (!topic.type_hash.empty()) received.metadata["topic_type_hash"] = topic.type_hash;
    ros::TopicType of = is_known ? known->second.type : ros::TopicType{topic.type, "*", "", ""};
    of.hash = topic.type_hash;
    ros::Qos queue = topic.qos;
    queue.depth = std::max<std::size_t>(queue.depth, 1000);
    const auto* kind = is_known ? &known->second : nullptr;
    subscriptions_[topic.name] = node_.raw().subscribe(
        topic.name, of, queue,
        [this, received, kind](std::string_view bytes, std::int64_t received_ns) {
          take(received, kind, bytes, LogTime::from_nanoseconds(received_ns));
        });
  }
  void take(const ros::ReceivedTopic& topic, const examples::MessageKind* kind,
            std::string_view bytes, LogTime received) {
    if (failed_) return;
    std::string converted;
    if (kind != nullptr && node_.dialect() == ros::Dialect::ros1) {
      auto cdr = kind->convert(bytes, ros::Dialect::ros1, ros::Dialect::ros2);
      if (!cdr) return node_.say(ros::Severity::error, cdr.error().to_string());
      bytes = converted = *std::move(cdr);
    }
    if (const auto done = writer_.write_received(topic, received, bytes); !done)
      return void(failed_ = done.error());
    auto& counted = topics_.at(topic.name);
    first_ = messages_ == 0 ? received : std::min(first_, received);
    last_ = std::max(last_, received);
    ++counted.messages, ++messages_;
  }

  ros::Node& node_;
  ros::RecordingWriter writer_;
  std::set<std::string> wanted_, left_out_, subscribed_;
  std::map<std::string, examples::RecordedTopic> topics_;
  std::map<std::string, ros::RawSubscription> subscriptions_;
  std::uint64_t messages_ = 0;
  LogTime first_, last_;
  std::optional<Error> failed_;
};

Result<void> record(ros::Node& node, const Arguments& a) {
  const std::string name = std::filesystem::path(a.out).filename().string();
  const std::string file = (name.empty() ? "recording" : name) + "_0.mcap";
  if (auto ok = a.prepare({file, "metadata.yaml"}); !ok) return ok;
  auto writer = ros::RecordingWriter::create(a.path(file), a.write());
  if (!writer) return writer.error();
  Recorder recorder(node, *std::move(writer), a);
  const auto recorded = recorder.run(a.seconds);
  recorder.report();
  if (!recorded) return recorded;
  return io::write_file(a.path("metadata.yaml"), recorder.metadata(file), a.write());
}

}  // namespace

int main(int argc, char** argv) {
  Arguments a;
  examples::CommandLine app(
      "Record live ROS topics into a folder that `ros2 bag` and Foxglove read: MCAP with CDR, and "
      "metadata.yaml. Runs until it is interrupted. Topics of unknown types are recorded too, in "
      "ROS 2, without their definition.");
  examples::add_out(app, a, "folder for the recording, created if needed");
  app.add_option("--only", a.topics, "a topic to record; repeatable; by default all").take_all();
  app.add_option("--leave-out", a.leave_out, "a topic to leave out; repeatable").take_all();
  app.add_option("--seconds", a.seconds, "ends after this time").positive();
  examples::add_force_and_quiet(app, a);
  app.example("--out drive", "all topics, until Ctrl-C");
  app.example("--out drive --only /scan --only /odom --seconds 60", "two topics for a minute");
  const auto started = examples::start_node(argc, argv, "record_topics", app);
  if (!started.node) return started.exit_code;
  const auto done = record(*started.node, a);
  if (!done) started.node->say(ros::Severity::error, done.error().to_string());
  return done ? 0 : 1;
}
