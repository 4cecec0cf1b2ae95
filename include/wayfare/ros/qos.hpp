#pragma once

// Quality of service of a topic, by ROS 2's names. Also compiled as C++17.

#include <cstddef>

namespace wayfare::ros {

/// Whether lost messages are sent again.
enum class Reliability {
  reliable,     ///< until received, as long as the publisher's queue contains them
  best_effort,  ///< never
};

/// Whether a publisher keeps messages for later subscribers.
enum class Durability {
  volatile_messages,  ///< no
  transient_local,    ///< up to `depth` of them, as "latched" topics of ROS 1
};

/// What a publisher offers, or the most a subscriber asks for: where a publisher offers less, a
/// subscriber of wayfare takes that and says so. ROS 1 is always reliable.
struct Qos {
  Reliability reliability = Reliability::reliable;        ///< of each message
  Durability durability = Durability::volatile_messages;  ///< of past messages
  std::size_t depth = 1000;  ///< messages in a queue, the oldest are dropped first

  /// Reliable, with a queue of `depth`.
  [[nodiscard]] static Qos queue(std::size_t depth) {
    return {Reliability::reliable, Durability::volatile_messages, depth};
  }
  /// ROS 2's profile for sensors: best effort, few messages.
  [[nodiscard]] static Qos sensor_data(std::size_t depth = 5) {
    return {Reliability::best_effort, Durability::volatile_messages, depth};
  }
  /// Of maps and static transforms: the last message is for later subscribers too.
  [[nodiscard]] static Qos latched(std::size_t depth = 1) {
    return {Reliability::reliable, Durability::transient_local, depth};
  }
};

}  // namespace wayfare::ros
