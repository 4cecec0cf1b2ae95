#pragma once

// librosbag_storage as a peer for bags; C++17, as ROS 1's headers are.

#include <cstdint>
#include <string>
#include <vector>

namespace peer {

struct Message {
  std::string topic, type, md5, data;
  std::uint32_t sec = 0, nanosec = 0;

  friend bool operator==(const Message& a, const Message& b) {
    return a.topic == b.topic && a.type == b.type && a.md5 == b.md5 && a.data == b.data &&
           a.sec == b.sec && a.nanosec == b.nanosec;
  }
};

/// All messages in order of time; throws if the bag is not valid.
std::vector<Message> read_bag(const std::string& path);

/// The same messages with chunks compressed by "lz4", "bz2" or "none".
void copy_bag(const std::string& from, const std::string& to, const std::string& compression);

}  // namespace peer
