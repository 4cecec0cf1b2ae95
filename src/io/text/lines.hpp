#pragma once

// Private: text files read line by line: time stamps, poses, and what all readers do with a file.

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <wayfare/core/result.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/io/text_file.hpp>

#include "io/text/text.hpp"

namespace wayfare::io {

/// Stamps are within 142 years of the epoch: the difference of any two fits 64 bits, and so does a
/// stamp of 2³² s, which logs contain that print a negative one as unsigned.
inline constexpr std::int64_t kLargestStamp_ns = 4'500'000'000'000'000'000;

/// A time stamp of a file.
inline std::optional<LogTime> parse_stamp(std::string_view token) {
  const std::optional<std::int64_t> ns = parse_nanoseconds(token);
  if (!ns || *ns > kLargestStamp_ns || *ns < -kLargestStamp_ns) return std::nullopt;
  return LogTime::from_nanoseconds(*ns);
}

/// The pose of `x y z qx qy qz qw`; nullopt where the quaternion is not of unit length, with a
/// tolerance for rounding of the text.
inline std::optional<SE3d> pose_of(const double* v) {
  const Eigen::Quaterniond q(v[6], v[3], v[4], v[5]);
  if (!(std::abs(q.norm() - 1.0) < 0.01)) return std::nullopt;
  return SE3d({v[0], v[1], v[2]}, SO3d(q));
}

inline void append_pose(std::string& out, const Eigen::Vector3d& t, const Eigen::Quaterniond& q) {
  text::append_numbers(out, {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()});
}

/// Calls `take(line, lines)` for each line for which `is_skipped(line, lines)` is false; `lines`
/// gives its number. `take` returns an error message, or an empty string. Returns the number of
/// accepted lines.
template <class IsSkipped, class Take>
std::size_t for_each_line(std::string_view all, const std::string& source, Problems& problems,
                          const IsSkipped& is_skipped, const Take& take) {
  std::size_t taken = 0;
  text::Lines lines(all);
  for (std::string_view line; lines.next(line);) {
    if (is_skipped(line, lines)) continue;
    if (std::string message = take(line, lines); !message.empty()) {
      problems.add(Error{ErrorCode::parse, std::move(message), source, lines.number()});
    } else {
      ++taken;
    }
  }
  return taken;
}

/// The same with `take(times, numbers)` for lines of `kTimes` time stamps and `kNumbers` finite
/// numbers. Comments and empty lines are skipped.
template <std::size_t kTimes, std::size_t kNumbers, class Take>
std::size_t for_each_pose_line(std::string_view all, const std::string& source, Problems& problems,
                               const Take& take) {
  const auto is_skipped = [](std::string_view line, const text::Lines&) {
    const std::string_view first = text::Tokens(line).next();
    return first.empty() || first.front() == '#';
  };
  const auto take_line = [&](std::string_view line, const text::Lines&) -> std::string {
    text::Tokens tokens(line);
    std::array<LogTime, kTimes> times;
    std::array<double, kNumbers> numbers{};
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
  };
  return for_each_line(all, source, problems, is_skipped, take_line);
}

/// The error for a file without any accepted line.
inline Error no_content(const char* what, const std::string& source, const Problems& problems) {
  std::string message = "contains no " + std::string(what);
  if (problems.empty()) return Error{ErrorCode::parse, std::move(message), source};
  const Error& first = problems.first().front();
  return Error{ErrorCode::parse, message + "; first problem: " + first.message, source, first.line};
}

/// Of a compressed file whose content up to the damage is used.
inline Error with_data_before(Error damage) {
  damage.message += "; the data before that is used";
  return damage;
}

/// `parse(bytes, path, arguments...)` of a file's content; a damaged gzip stream adds a problem.
template <class Parse, class... Arguments>
auto read_and_parse(const std::string& path, const ReadOptions& options, const Parse& parse,
                    const Arguments&... arguments)
    -> decltype(parse(std::string_view(), path, arguments...)) {
  const Result<FileContent> content = read_file(path, options);
  if (!content) return content.error();
  auto file = parse(content->bytes, path, arguments...);
  if (file && content->damage) file->problems.add(with_data_before(*content->damage));
  return file;
}

}  // namespace wayfare::io
