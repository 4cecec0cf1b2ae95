#pragma once

// Private: text files with lines of time stamps followed by numbers.

#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include <wayfare/core/result.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/io/text_file.hpp>

#include "io/text/stamp.hpp"
#include "io/text/text.hpp"

namespace wayfare::io {

/// Calls `take(times, numbers)` for each line of `kTimes` time stamps and `kNumbers` finite
/// numbers; `take` returns an error message, or an empty string. Comments and empty lines are
/// skipped. Returns the number of accepted lines.
template <std::size_t kTimes, std::size_t kNumbers, class Take>
std::size_t for_each_pose_line(std::string_view all, const std::string& source, Problems& problems,
                               Take take) {
  std::size_t taken = 0;
  text::Lines lines(all);
  for (std::string_view line; lines.next(line);) {
    text::Tokens tokens(line);
    if (tokens.at_end() || text::Tokens(line).next().front() == '#') continue;
    std::array<LogTime, kTimes> times;
    std::array<double, kNumbers> numbers{};
    const auto message = [&]() -> std::string {
      for (LogTime& time : times) {
        const std::string_view token = tokens.next();
        const std::optional<LogTime> stamp = parse_stamp(token);
        if (!stamp) return "not a time stamp: '" + text::printable(token) + "'";
        time = *stamp;
      }
      for (double& number : numbers) {
        const std::string_view token = tokens.next();
        if (token.empty()) return "fewer than " + std::to_string(kTimes + kNumbers) + " numbers";
        if (!text::to_number(token, number) || !std::isfinite(number))
          return "not a finite number: '" + text::printable(token) + "'";
      }
      if (!tokens.at_end()) return "more than " + std::to_string(kTimes + kNumbers) + " numbers";
      return take(times, numbers);
    }();
    if (message.empty()) {
      ++taken;
    } else {
      problems.add(Error{ErrorCode::parse, message, source, lines.number()});
    }
  }
  return taken;
}

/// The error for a file without any accepted line.
inline Error no_content(const char* what, const std::string& source, const Problems& problems) {
  std::string message = "contains no " + std::string(what);
  if (problems.empty()) return Error{ErrorCode::parse, std::move(message), source};
  const Error& first = problems.first().front();
  return Error{ErrorCode::parse, message + "; first problem: " + first.message, source, first.line};
}

/// Reads and parses a file; a damaged gzip stream adds a problem.
template <class File, class Parse>
Result<File> read_and_parse(const std::string& path, const ReadOptions& options, Parse parse) {
  const Result<FileContent> content = read_file(path, options);
  if (!content) return content.error();
  Result<File> file = parse(content->bytes, path);
  if (file && content->damage) file->problems.add(*content->damage);
  return file;
}

}  // namespace wayfare::io
