#pragma once

// A ROS 1 node that transfers bytes: the only part compiled with roscpp, whose headers are C++17,
// as this header is. `node.hpp` is the same with messages.

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/ros/detail/node_output.hpp>

namespace wayfare::ros {

/// A topic's message type, as ROS 1 distinguishes them.
struct TopicType {
  std::string name;        ///< "sensor_msgs/LaserScan"
  std::string md5;         ///< of the definition
  std::string definition;  ///< for recorders
};

/// Publishes on one topic during its lifetime.
struct RawPublisher {
  std::function<void(const std::string& bytes)> publish;  ///< sends a serialised message
  std::function<std::size_t()> subscribers;               ///< number of nodes connected
};

/// The process's only node: roscpp allows one. Callbacks are called by `spin` only, on its thread.
class RawNode {
 public:
  /// Removes ROS's own arguments (`scan:=front/scan`, `__name:=…`, `_parameter:=…`) from
  /// `arguments` (the first is the program). Nothing is sent yet. SIGINT and SIGTERM end the node.
  RawNode(std::vector<std::string>& arguments, const std::string& name);
  ~RawNode();
  RawNode(const RawNode&) = delete;
  RawNode& operator=(const RawNode&) = delete;

  /// Waits for the master and reports it on standard error; false if the node was ended before.
  [[nodiscard]] bool connect();
  /// False once the node has been ended.
  [[nodiscard]] bool ok() const;

  /// The node's private parameters with plain values, as text.
  [[nodiscard]] std::vector<std::pair<std::string, std::string>> parameters() const;

  /// A latched topic keeps its last message for later subscribers.
  [[nodiscard]] RawPublisher advertise(const std::string& topic, const TopicType& type,
                                       bool latched);
  /// Up to `queue` messages are queued for `spin`; the oldest are dropped first.
  void subscribe(const std::string& topic, const TopicType& type, std::uint32_t queue,
                 std::function<void(const std::string& bytes)> callback);

  /// Calls the callbacks of all queued messages; waits up to `seconds` if there are none.
  void spin(double seconds);

  /// Nanoseconds of ROS time: simulated if the parameter /use_sim_time is set, and then zero until
  /// a clock message is received.
  [[nodiscard]] std::int64_t now_ns() const;
  /// Logs as ROS does: to standard output, errors and warnings to standard error, and to /rosout.
  void say(Severity severity, const std::string& text) const;

 private:
  struct Connected;
  std::unique_ptr<Connected> connected_;
};

}  // namespace wayfare::ros
