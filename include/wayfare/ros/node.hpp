#pragma once

// A node with messages as plain values, on the transport of ROS 1 (`ros1_node`) or ROS 2
// (`ros2_node`).

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <wayfare/ros/detail/raw_node.hpp>
#include <wayfare/ros/qos.hpp>
#include <wayfare/ros/serialise.hpp>

namespace wayfare::ros {

/// Name, MD5 sum and definition of a message type, as ROS 1 negotiates them; ROS 2 uses the name.
template <Message M>
[[nodiscard]] TopicType topic_type() {
  return {std::string(M::kType.name), std::string(M::kType.md5), definition<M>(Dialect::ros1)};
}

/// Sends messages of one type.
template <Message M>
class Publisher {
 public:
  /// Of an advertised topic, by the serialisation of its system.
  Publisher(RawPublisher raw, Dialect dialect) : raw_(std::move(raw)), dialect_(dialect) {}
  /// Serialises and sends a message.
  void publish(const M& message) { raw_.publish(to_bytes(message, dialect_)); }
  /// Number of nodes connected.
  [[nodiscard]] std::size_t subscribers() const { return raw_.subscribers(); }

 private:
  RawPublisher raw_;
  Dialect dialect_;
};

/// What became of the messages of a subscribed topic.
struct TopicCounts {
  std::string topic;           ///< with its namespaces
  std::uint64_t received = 0,  ///< valid messages
      refused = 0,             ///< messages that are not what their type is
      lost = 0;                ///< on the way or in a full queue; ROS 1 does not report it
};

/// A node. Not thread-safe.
class Node {
 public:
  /// On a transport.
  explicit Node(std::unique_ptr<RawNode> raw) : raw_(std::move(raw)) {}
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;

  /// The transport: connecting, parameters, spinning, time and log.
  [[nodiscard]] RawNode& raw() { return *raw_; }
  /// False once the node has been ended.
  [[nodiscard]] bool ok() const { return raw_->ok(); }
  /// Calls the callbacks of all queued messages; waits up to `seconds` if there are none.
  void spin(double seconds) { raw_->spin(seconds); }
  /// Nanoseconds of ROS time: simulated if the parameter `use_sim_time` is set, and then zero until
  /// a clock message is received.
  [[nodiscard]] std::int64_t now_ns() const { return raw_->now_ns(); }
  /// Logs as the system does.
  void say(Severity severity, const std::string& text) const { raw_->say(severity, text); }
  /// How the system serialises messages.
  [[nodiscard]] Dialect dialect() const {
    return std::string_view(raw_->system()) == "ros1" ? Dialect::ros1 : Dialect::ros2;
  }

  /// Begins to publish on a topic.
  template <Message M>
  [[nodiscard]] Publisher<M> publisher(const std::string& topic, const Qos& qos = {}) {
    return Publisher<M>(raw_->advertise(topic, topic_type<M>(), qos), dialect());
  }
  /// Messages that are not what their type is are dropped and counted; the first is reported.
  template <Message M>
  void subscribe(const std::string& topic, const Qos& qos, std::function<void(const M&)> callback) {
    auto counts = std::make_shared<Subscribed>();
    subscribed_.push_back(counts);
    counts->raw = raw_->subscribe(
        topic, topic_type<M>(), qos,
        [this, counts, callback = std::move(callback)](std::string_view bytes, std::int64_t) {
          const auto message = from_bytes<M>(bytes, dialect());
          if (message) return ++counts->received, callback(*message);
          if (++counts->refused == 1)
            say(Severity::error, "leaves out messages on '" + counts->raw.topic +
                                     "' that are damaged: " + message.error().to_string());
        });
  }
  /// Of every subscription.
  [[nodiscard]] std::vector<TopicCounts> counts() const {
    std::vector<TopicCounts> all;
    for (const auto& s : subscribed_)
      all.push_back({s->raw.topic, s->received, s->refused, s->raw.lost()});
    return all;
  }

 private:
  struct Subscribed {
    RawSubscription raw;
    std::uint64_t received = 0, refused = 0;
  };
  std::vector<std::shared_ptr<Subscribed>> subscribed_;
  std::unique_ptr<RawNode> raw_;
};

}  // namespace wayfare::ros
