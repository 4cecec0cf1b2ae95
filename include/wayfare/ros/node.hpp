#pragma once

// A ROS 1 node with messages as plain values. Needs roscpp, which only the compiled part includes.

#include <cstdint>
#include <functional>
#include <string>
#include <utility>

#include <wayfare/ros/detail/raw_node.hpp>
#include <wayfare/ros/serialise.hpp>

namespace wayfare::ros {

/// Name, MD5 sum and definition of a message type, as ROS 1 negotiates them.
template <Message M>
[[nodiscard]] TopicType topic_type() {
  return {std::string(M::kType.name), std::string(M::kType.md5), definition<M>(Dialect::ros1)};
}

/// Sends messages of one type.
template <Message M>
class Publisher {
 public:
  /// Of an advertised topic.
  explicit Publisher(RawPublisher raw) : raw_(std::move(raw)) {}
  /// Serialises and sends a message.
  void publish(const M& message) { raw_.publish(to_ros1(message)); }
  /// Number of nodes connected.
  [[nodiscard]] std::size_t subscribers() const { return raw_.subscribers(); }

 private:
  RawPublisher raw_;
};

/// A ROS 1 node.
class Node : public RawNode {
 public:
  using RawNode::RawNode;

  /// Advertises a topic.
  template <Message M>
  [[nodiscard]] Publisher<M> publisher(const std::string& topic) {
    return Publisher<M>(advertise(topic, topic_type<M>(), false));
  }
  /// The last message is kept for later subscribers.
  template <Message M>
  [[nodiscard]] Publisher<M> latched_publisher(const std::string& topic) {
    return Publisher<M>(advertise(topic, topic_type<M>(), true));
  }

  /// An invalid message is reported and dropped.
  template <Message M>
  void subscribe(const std::string& topic, std::uint32_t queue,
                 std::function<void(const M&)> callback) {
    RawNode::subscribe(topic, topic_type<M>(), queue,
                       [this, topic, callback = std::move(callback)](const std::string& bytes) {
                         const auto message = from_ros1<M>(bytes);
                         if (message) return callback(*message);
                         say(Severity::error, "left out a message on '" + topic +
                                                  "': " + message.error().to_string());
                       });
  }
};

}  // namespace wayfare::ros
