#pragma once

// A file of messages with topic, type and time: each record is the time in nanoseconds (8 bytes),
// and topic, type and bytes, each after its length (4 bytes); little endian. C++17.

#include <cstdint>
#include <cstring>
#include <fstream>
#include <istream>
#include <ostream>
#include <stdexcept>
#include <string>
#include <vector>

namespace peer {

struct Record {
  std::int64_t time_ns = 0;
  std::string topic, type;  ///< of DDS (rt/scan), and of ROS 2 (sensor_msgs/msg/LaserScan)
  std::string bytes;        ///< CDR, with the four bytes of its encoding
};

template <class T>
void write_number(std::ostream& to, T number) {
  for (std::size_t i = 0; i < sizeof(T); ++i)
    to.put(static_cast<char>(static_cast<std::uint64_t>(number) >> (8 * i) & 0xffU));
}

template <class T>
T read_number(std::istream& from) {
  std::uint64_t number = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i)
    number |= static_cast<std::uint64_t>(from.get() & 0xff) << (8 * i);
  return static_cast<T>(number);
}

inline void write_record(std::ostream& to, const Record& r) {
  write_number(to, r.time_ns);
  for (const std::string* text : {&r.topic, &r.type, &r.bytes}) {
    write_number(to, static_cast<std::uint32_t>(text->size()));
    to.write(text->data(), static_cast<std::streamsize>(text->size()));
  }
}

inline std::vector<Record> read_records(const std::string& path) {
  std::ifstream from(path, std::ios::binary);
  if (!from) throw std::runtime_error(path + " cannot be read");
  std::vector<Record> records;
  while (from.peek() != std::istream::traits_type::eof()) {
    Record r;
    r.time_ns = read_number<std::int64_t>(from);
    for (std::string* text : {&r.topic, &r.type, &r.bytes}) {
      text->resize(read_number<std::uint32_t>(from));
      from.read(text->data(), static_cast<std::streamsize>(text->size()));
    }
    if (!from) throw std::runtime_error(path + " ends within a record");
    records.push_back(r);
  }
  return records;
}

}  // namespace peer
