#pragma once

// A ROS 1 node that speaks bytes: the only thing compiled against roscpp, whose headers are C++17.
// That is why this header is as well; `node.hpp` gives the same with messages.

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/ros/detail/node_output.hpp>

namespace wayfare::ros {

/// What a topic carries, as ROS 1 tells kinds of messages apart.
struct TopicType {
  std::string name;        ///< "sensor_msgs/LaserScan"
  std::string md5;         ///< of the definition
  std::string definition;  ///< for recorders
};

/// Sends on one topic, as long as it lives.
class RawPublisher {
 public:
  virtual ~RawPublisher() = default;
  virtual void publish(const std::string& bytes) = 0;
  [[nodiscard]] virtual std::size_t subscribers() const = 0;
};

/// The process's node: roscpp knows one. Callbacks are called by `spin` alone, on its thread.
class RawNode {
 public:
  /// Takes ROS's own arguments (`scan:=front/scan`, `__name:=…`, `_parameter:=…`) out of
  /// `arguments` (the first is the program). Nothing is sent yet. SIGINT and SIGTERM end the node.
  RawNode(std::vector<std::string>& arguments, const std::string& name);
  ~RawNode();
  RawNode(const RawNode&) = delete;
  RawNode& operator=(const RawNode&) = delete;

  /// Waits for the master, saying on standard error that it does; false where the node was ended
  /// before there was one.
  [[nodiscard]] bool connect();
  /// False once the node was ended.
  [[nodiscard]] bool ok() const;

  /// The node's private parameters that are plain values, as text.
  [[nodiscard]] std::vector<std::pair<std::string, std::string>> parameters() const;

  /// A latched topic keeps its last message for who subscribes later.
  [[nodiscard]] std::unique_ptr<RawPublisher> advertise(const std::string& topic,
                                                        const TopicType& type, bool latched);
  /// Up to `queue` messages wait for `spin`; the oldest are lost first.
  void subscribe(const std::string& topic, const TopicType& type, std::uint32_t queue,
                 std::function<void(const std::string& bytes)> callback);

  /// Calls the callbacks of all messages there are; waits up to `seconds` where there is none.
  void spin(double seconds);

  /// Nanoseconds of the time all nodes go by: simulated where the parameter /use_sim_time says so,
  /// and then zero until a clock is heard.
  [[nodiscard]] std::int64_t now_ns() const;
  /// Where ROS says things: standard output, errors and warnings to standard error, and /rosout.
  void say(Severity severity, const std::string& text) const;

 private:
  struct Connected;
  std::unique_ptr<Connected> connected_;
};

}  // namespace wayfare::ros
