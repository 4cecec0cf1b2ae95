#pragma once

// Recordings for tests, written to memory.

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <wayfare/io/mcap.hpp>
#include <wayfare/io/text_file.hpp>

namespace wayfare::testing {

/// Stores what is written; rejects writes beyond `room` bytes.
class MemorySink final : public io::ByteSink {
 public:
  explicit MemorySink(std::shared_ptr<std::string> bytes, std::size_t room = SIZE_MAX)
      : bytes_(std::move(bytes)), room_(room) {}
  Result<void> write(std::string_view more) override {
    if (more.size() > room_ - bytes_->size()) return Error{ErrorCode::io, "no room left", "memory"};
    *bytes_ += more;
    return {};
  }
  Result<void> sync() override { return {}; }

 private:
  std::shared_ptr<std::string> bytes_;
  std::size_t room_;
};

/// A copy of a message for comparison.
struct Remembered {
  std::string topic, data;
  std::uint32_t sequence = 0;
  LogTime log_time, publish_time;

  bool operator==(const Remembered&) const = default;
};

inline std::vector<Remembered> read_all(const io::McapReader& reader,
                                        const io::McapQuery& query = {},
                                        io::Problems* problems = nullptr) {
  std::vector<Remembered> all;
  const io::Problems met = reader.read(query, [&](const io::McapMessage& m) {
    all.push_back({m.channel->topic, std::string(m.data), m.sequence, m.log_time, m.publish_time});
    return true;
  });
  if (problems != nullptr) *problems = met;
  return all;
}

}  // namespace wayfare::testing
