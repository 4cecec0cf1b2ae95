#pragma once

// A type of Fast DDS whose messages are bytes as they are, under any type's name: for messages that
// are not what their type says. C++17.

#include <algorithm>
#include <cstdint>
#include <functional>
#include <string>

#include <fastdds/dds/topic/TopicDataType.hpp>

namespace peer {

/// DDS's name of a type of ROS 2: sensor_msgs::msg::dds_::Imu_ of sensor_msgs/msg/Imu.
inline std::string dds_name(const std::string& ros2_name) {
  const std::size_t package = ros2_name.find('/'), type = ros2_name.rfind('/');
  if (package == std::string::npos) return ros2_name;
  return ros2_name.substr(0, package) + "::msg::dds_::" + ros2_name.substr(type + 1) + "_";
}

/// Its samples are of std::string, with the four bytes of their encoding.
class RawType : public eprosima::fastdds::dds::TopicDataType {
 public:
  explicit RawType(const std::string& name) {
    setName(name.c_str());
    m_typeSize = 1024;
    m_isGetKeyDefined = false;
  }

  bool serialize(void* data, eprosima::fastrtps::rtps::SerializedPayload_t* to) override {
    const auto& bytes = *static_cast<std::string*>(data);
    if (bytes.size() > to->max_size) return false;
    std::copy(bytes.begin(), bytes.end(), reinterpret_cast<char*>(to->data));
    to->length = static_cast<std::uint32_t>(bytes.size());
    to->encapsulation = CDR_LE;
    return true;
  }
  bool deserialize(eprosima::fastrtps::rtps::SerializedPayload_t* from, void* data) override {
    static_cast<std::string*>(data)->assign(reinterpret_cast<const char*>(from->data),
                                            from->length);
    return true;
  }
  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override {
    return [data] { return static_cast<std::uint32_t>(static_cast<std::string*>(data)->size()); };
  }
  void* createData() override { return new std::string; }
  void deleteData(void* data) override { delete static_cast<std::string*>(data); }
  bool getKey(void*, eprosima::fastrtps::rtps::InstanceHandle_t*, bool) override { return false; }
};

}  // namespace peer
