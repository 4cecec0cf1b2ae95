#pragma once

// Serialisation of ROS messages: CDR as in ROS 2 (little or big endian, plain, version 1 or 2) and
// the packed format of ROS 1. Lengths in a message are limited by its number of bytes.

#include <concepts>
#include <string>
#include <string_view>

#include <wayfare/core/result.hpp>
#include <wayfare/ros/messages.hpp>

namespace wayfare::ros {

/// A complete ROS message: implemented for those of messages.hpp.
template <class M>
concept Message = requires {
  M::kType.md5;
};

/// Serialisation of messages: packed as in ROS 1, or CDR as in ROS 2.
enum class Dialect {
  ros1,  ///< packed, little endian
  ros2,  ///< CDR
};
/// Of the numbers in a CDR message.
enum class ByteOrder {
  little,  ///< least significant byte first
  big,     ///< most significant byte first
};

/// With the four leading bytes that give the encoding.
template <Message M>
[[nodiscard]] std::string to_cdr(const M& message, ByteOrder order = ByteOrder::little);
/// Errors: an encoding other than plain CDR; fewer bytes than the message needs, or more than its
/// end and padding.
template <Message M>
[[nodiscard]] Result<M> from_cdr(std::string_view bytes);

/// Packed, little endian.
template <Message M>
[[nodiscard]] std::string to_ros1(const M& message);
/// Errors: fewer or more bytes than the message needs.
template <Message M>
[[nodiscard]] Result<M> from_ros1(std::string_view bytes);

/// Serialised as `dialect` has it, CDR little endian.
template <Message M>
[[nodiscard]] std::string to_bytes(const M& message, Dialect dialect) {
  return dialect == Dialect::ros1 ? to_ros1(message) : to_cdr(message);
}
/// The inverse of to_bytes. Errors: those of from_cdr or from_ros1.
template <Message M>
[[nodiscard]] Result<M> from_bytes(std::string_view bytes, Dialect dialect) {
  return dialect == Dialect::ros1 ? from_ros1<M>(bytes) : from_cdr<M>(bytes);
}

/// The definition as in a bag: fields by type and name, followed by the definitions of nested
/// messages.
template <Message M>
[[nodiscard]] std::string definition(Dialect dialect);

/// `sensor_msgs/Imu` in the notation of ROS 2: `sensor_msgs/msg/Imu`; and back. Other names are
/// kept.
[[nodiscard]] std::string ros2_name(std::string_view ros1_name);
/// The inverse of ros2_name.
[[nodiscard]] std::string ros1_name(std::string_view ros2_name);

}  // namespace wayfare::ros
