#pragma once

#include <cstdint>
#include <utility>

#include <wayfare/core/time.hpp>

namespace wayfare::logger {

/// Whole seconds, rounded down, and the nanoseconds from there on, as messages have them.
[[nodiscard]] inline std::pair<std::int64_t, std::int64_t> seconds_and_rest(LogTime time) {
  constexpr std::int64_t kSecond = 1'000'000'000;
  const std::int64_t ns = time.nanoseconds(), rest = ns % kSecond;
  return rest < 0 ? std::pair(ns / kSecond - 1, rest + kSecond) : std::pair(ns / kSecond, rest);
}

}  // namespace wayfare::logger
