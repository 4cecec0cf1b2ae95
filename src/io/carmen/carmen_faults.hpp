#pragma once

// Private: reports the faults of a CARMEN log.

#include <string>
#include <utility>

#include <wayfare/io/carmen.hpp>

namespace wayfare::io::carmen {

/// Adds to a log's problems.
class Faults {
 public:
  Faults(std::string source, CarmenLog& log) : source_(std::move(source)), log_(log) {}

  /// Reports a problem of a line that is used.
  void note(Error error, std::size_t line) {
    error.source = source_;
    error.line = line;
    log_.problems.add(std::move(error));
  }
  /// Reports a problem of a line that is skipped.
  void skip(Error error, std::size_t line) {
    note(std::move(error), line);
    ++log_.statistics.skipped_lines;
  }

  [[nodiscard]] const std::string& source() const { return source_; }

 private:
  std::string source_;
  CarmenLog& log_;
};

}  // namespace wayfare::io::carmen
