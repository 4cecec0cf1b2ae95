#pragma once

#include <utility>

namespace wayfare {

/// A value that is T() again once it was moved from: for sizes kept beside a container, which a
/// move empties.
template <class T>
struct ResetOnMove {
  T value{};

  ResetOnMove() = default;
  ResetOnMove(T v) : value(std::move(v)) {}  // NOLINT(*-explicit*)
  ResetOnMove(const ResetOnMove&) = default;
  ResetOnMove(ResetOnMove&& o) noexcept : value(std::exchange(o.value, T())) {}
  ResetOnMove& operator=(const ResetOnMove&) = default;
  ResetOnMove& operator=(ResetOnMove&& o) noexcept {
    value = std::exchange(o.value, T());
    return *this;
  }
  ~ResetOnMove() = default;

  operator const T&() const { return value; }  // NOLINT(*-explicit*)
};

}  // namespace wayfare
