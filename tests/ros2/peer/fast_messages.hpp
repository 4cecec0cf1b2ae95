#pragma once

// Messages in the types that Fast DDS's generator makes of ros_messages.idl, written and read by
// Fast CDR. C++17, and nothing of ours.

#include <cstdint>
#include <string>
#include <vector>

namespace eprosima::fastdds::dds {
class TypeSupport;
}

namespace peer {

/// Names of the types known, as ROS 2 has them: sensor_msgs/msg/LaserScan.
[[nodiscard]] std::vector<std::string> type_names();

/// A message of a type; the name must be known.
class FastMessage {
 public:
  explicit FastMessage(const std::string& type);
  ~FastMessage();
  FastMessage(const FastMessage&) = delete;
  FastMessage& operator=(const FastMessage&) = delete;

  /// Its type, as Fast DDS registers it.
  [[nodiscard]] const eprosima::fastdds::dds::TypeSupport& type() const;
  /// For DataWriter::write and DataReader::take_next_sample.
  [[nodiscard]] void* data() { return data_; }

  /// Sets the values of a sample of Formula.
  void fill(std::uint32_t sample, std::uint32_t size);
  /// The first value that is not of that sample; empty if there is none.
  [[nodiscard]] std::string difference(std::uint32_t sample, std::uint32_t size);

  /// As Fast CDR writes it, with the four bytes of its encoding.
  [[nodiscard]] std::string to_bytes();
  /// False if Fast CDR refuses the bytes.
  [[nodiscard]] bool from_bytes(const std::string& bytes);

 private:
  struct Kind;
  [[nodiscard]] static const std::vector<Kind>& kinds();
  friend std::vector<std::string> type_names();

  const Kind& kind_;
  void* data_;
};

}  // namespace peer
