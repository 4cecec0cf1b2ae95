#pragma once

// A node that transfers bytes, of ROS 1 or ROS 2. C++17, as roscpp's headers are; `node.hpp` is the
// same with messages.

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <wayfare/ros/detail/node_output.hpp>
#include <wayfare/ros/qos.hpp>

namespace wayfare::ros {

/// A topic's message type.
struct TopicType {
  std::string name;        ///< "sensor_msgs/LaserScan", in ROS 2 as well
  std::string md5;         ///< of the definition, ROS 1 only; "*": any
  std::string definition;  ///< for recorders, ROS 1 only
  std::string hash = {};   ///< ROS 2 only; empty: that of messages.hpp
};

/// A topic that somebody publishes.
struct PublishedTopic {
  std::string name;       ///< with its namespaces: "/robot/scan"
  std::string type;       ///< "sensor_msgs/LaserScan", in ROS 2 as well
  std::string type_hash;  ///< ROS 2 from Iron on: "RIHS01_…"; or empty
  Qos qos;                ///< as offered; of several publishers one's
};

/// Publishes on one topic during its lifetime.
struct RawPublisher {
  std::function<void(std::string_view bytes)> publish;  ///< sends a serialised message
  std::function<std::size_t()> subscribers;             ///< number of nodes connected
};

/// A subscription, which lasts as long as the node.
struct RawSubscription {
  std::string topic;                    ///< with its namespaces
  std::function<std::uint64_t()> lost;  ///< messages sent, but lost on the way or in the queue
};

/// Called with a serialised message and its time of receipt by this computer's clock, ns.
using RawCallback = std::function<void(std::string_view bytes, std::int64_t received_ns)>;

/// Callbacks are called by `spin` only, on its thread. SIGINT and SIGTERM end the node.
class RawNode {
 public:
  RawNode() = default;
  virtual ~RawNode() = default;
  RawNode(const RawNode&) = delete;
  RawNode& operator=(const RawNode&) = delete;

  /// "ros1" or "ros2", as recordings call it.
  [[nodiscard]] virtual const char* system() const = 0;
  /// Joins the system; false if the node was ended before.
  [[nodiscard]] virtual bool connect() = 0;
  /// False once the node has been ended.
  [[nodiscard]] virtual bool ok() const = 0;
  /// The node's own parameters with plain values, as text.
  [[nodiscard]] virtual std::vector<std::pair<std::string, std::string>> parameters() const = 0;
  /// Of other nodes, as far as they are known yet.
  [[nodiscard]] virtual std::vector<PublishedTopic> topics() const = 0;
  /// Begins to publish.
  [[nodiscard]] virtual RawPublisher advertise(const std::string& topic, const TopicType& type,
                                               const Qos& qos) = 0;
  /// Begins to queue messages for `spin`.
  virtual RawSubscription subscribe(const std::string& topic, const TopicType& type, const Qos& qos,
                                    RawCallback callback) = 0;
  /// Calls the callbacks of all queued messages; waits up to `seconds` if there are none.
  virtual void spin(double seconds) = 0;
  /// Nanoseconds of ROS time: simulated if the parameter `use_sim_time` is set, and then zero until
  /// a clock message is received.
  [[nodiscard]] virtual std::int64_t now_ns() const = 0;
  /// Logs as the system does.
  virtual void say(Severity severity, const std::string& text) const = 0;
};

/// True once SIGINT or SIGTERM was received; they are handled from the first call on.
[[nodiscard]] bool interrupted();

}  // namespace wayfare::ros
