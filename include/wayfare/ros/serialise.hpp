#pragma once

// ROS messages to bytes and back: CDR as ROS 2 writes it (little or big endian, plain, version 1 or
// 2) and the packed bytes of ROS 1. Lengths are believed only as far as the bytes reach.

#include <concepts>
#include <string>
#include <string_view>

#include <wayfare/core/result.hpp>
#include <wayfare/ros/messages.hpp>

namespace wayfare::ros {

/// What a ROS message is: compiled for those of messages.hpp that travel by themselves.
template <class M>
concept Message = requires {
  M::kType.md5;
};

enum class Dialect { ros1, ros2 };
enum class ByteOrder { little, big };

/// With the four bytes in front that say how it is encoded.
template <Message M>
[[nodiscard]] std::string to_cdr(const M& message, ByteOrder order = ByteOrder::little);
/// Errors: an encoding other than plain CDR; fewer bytes than the message needs, or more than its
/// end and padding.
template <Message M>
[[nodiscard]] Result<M> from_cdr(std::string_view bytes);

template <Message M>
[[nodiscard]] std::string to_ros1(const M& message);
/// Errors: fewer or more bytes than the message needs.
template <Message M>
[[nodiscard]] Result<M> from_ros1(std::string_view bytes);

template <Message M>
[[nodiscard]] std::string to_bytes(const M& message, Dialect dialect) {
  return dialect == Dialect::ros1 ? to_ros1(message) : to_cdr(message);
}
template <Message M>
[[nodiscard]] Result<M> from_bytes(std::string_view bytes, Dialect dialect) {
  return dialect == Dialect::ros1 ? from_ros1<M>(bytes) : from_cdr<M>(bytes);
}

/// The definition as a bag holds it: fields by type and name, behind them those of the messages
/// within.
template <Message M>
[[nodiscard]] std::string definition(Dialect dialect);

/// `sensor_msgs/Imu` as ROS 2 calls it: `sensor_msgs/msg/Imu`; and back. Other names stand.
[[nodiscard]] std::string ros2_name(std::string_view ros1_name);
[[nodiscard]] std::string ros1_name(std::string_view ros2_name);

}  // namespace wayfare::ros
