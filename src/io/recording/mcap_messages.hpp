#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include <wayfare/io/mcap.hpp>

#include "io/recording/mcap_walk.hpp"

namespace wayfare::io::mcap {

/// Schemas and channels of a recording.
struct Description {
  std::map<std::uint16_t, McapSchema> schemas;
  std::map<std::uint16_t, McapChannel> channels;

  /// False where the record is malformed, or gives a known channel another topic.
  bool take(const Record& record);
};

/// Extracts messages from records; schemas and channels are registered in order of appearance.
class Messages {
 public:
  using Sink = std::function<bool(const McapMessage&)>;

  Messages(Description& known, const std::string& name, const McapReadOptions& options,
           Problems& problems)
      : known_(known), name_(name), options_(options), problems_(problems) {}

  /// The bytes to which the messages of the last record refer if that is a compressed chunk; null
  /// if they refer to the record's own bytes.
  [[nodiscard]] const std::shared_ptr<const std::string>& unpacked() const { return unpacked_; }

  /// Number of messages skipped because their channel was not described before.
  [[nodiscard]] std::size_t undescribed() const { return undescribed_; }

  /// False once `sink` returns false.
  bool take(const Record& record, const Sink& sink);

 private:
  /// A record of the file, or of a chunk.
  bool take_any(const Record& record, const Sink& sink);
  bool take_chunk(const Record& record, const Sink& sink);

  void fault(std::uint64_t at, std::string message) {
    problems_.add({ErrorCode::parse, std::move(message), name_, 0, static_cast<std::size_t>(at)});
  }

  Description& known_;
  const std::string& name_;
  const McapReadOptions& options_;
  Problems& problems_;
  std::shared_ptr<const std::string> unpacked_;
  std::size_t undescribed_ = 0;
};

}  // namespace wayfare::io::mcap
