#pragma once

// Names and creation of a recording's files.

#include <cstdint>
#include <string>

#include <wayfare/io/mcap.hpp>
#include <wayfare/logger/logger.hpp>

#include "logger/clock_watch.hpp"

namespace wayfare::logger {

class RecordingFiles {
 public:
  RecordingFiles(const LoggerOptions& options, const LoggerClock& clock)
      : options_(options), clock_(clock) {}

  /// Whether a recording may have several files.
  [[nodiscard]] bool rotates() const;
  /// The path of a recording that does not exist, by the present time, up to its part and suffix;
  /// empty: there is none left.
  [[nodiscard]] std::string free_base() const;
  /// Of a part, from 1 on.
  [[nodiscard]] std::string path_of(const std::string& base, std::uint32_t part) const;
  /// A file with its metadata. Error: it cannot be created.
  [[nodiscard]] Result<io::McapWriter> create(const std::string& base, std::uint32_t part,
                                              const io::McapMetadata& about) const;

 private:
  const LoggerOptions& options_;
  const LoggerClock& clock_;
};

}  // namespace wayfare::logger
