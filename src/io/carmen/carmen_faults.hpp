#pragma once

// Private: where what is wrong with a CARMEN log goes.

#include <string>
#include <utility>

#include <wayfare/io/carmen.hpp>

namespace wayfare::io::carmen {

/// Adds to a log's problems; both log and this outlive the reading.
class Faults {
 public:
  Faults(std::string source, CarmenLog& log) : source_(std::move(source)), log_(log) {}

  /// The line is used all the same.
  void note(Error error, std::size_t line) {
    error.source = source_;
    error.line = line;
    log_.problems.add(std::move(error));
  }
  /// The line is left out.
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
