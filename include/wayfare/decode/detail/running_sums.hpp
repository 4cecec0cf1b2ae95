#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include <wayfare/core/detail/bytes.hpp>

namespace wayfare::decode::detail {

/// Checksums of overlapping candidates for a frame, each a difference of two sums over the stream.
/// Every byte is added once: the sums of the last `kCapacity` + 1 positions are kept.
template <class Sum, std::size_t kCapacity>
class RunningSums {
 public:
  /// Whether the bytes at `position` have been added, wholly or in part.
  [[nodiscard]] bool contain(std::uint64_t position) const { return position < end_; }
  /// Of all bytes before `position` since the start; up to the end of what has been added.
  [[nodiscard]] const Sum& before(std::uint64_t position) const { return sums_[index(position)]; }

  void start(std::uint64_t position) {
    end_ = position;
    sums_[index(position)] = {};
  }
  /// Adds those of the bytes at `position` that are new by `add(sum, byte)`; returns their number.
  template <class Add>
  std::size_t extend(std::uint64_t position, Bytes bytes, const Add& add) {
    const std::uint64_t end = position + bytes.size();
    if (end <= end_) return 0;
    const auto n = static_cast<std::size_t>(end - end_);
    for (const std::uint8_t byte : bytes.last(n)) {
      sums_[index(end_ + 1)] = add(before(end_), byte);
      ++end_;
    }
    return n;
  }

 private:
  static std::size_t index(std::uint64_t position) {
    return static_cast<std::size_t>(position % std::bit_ceil(kCapacity + 1));
  }

  std::array<Sum, std::bit_ceil(kCapacity + 1)> sums_;  // NOLINT: set before it is used
  std::uint64_t end_ = 0;
};

}  // namespace wayfare::decode::detail
