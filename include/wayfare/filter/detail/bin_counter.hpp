#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

namespace wayfare {

/// The indices of a bin of a histogram along N directions.
template <std::size_t N>
using BinKey = std::array<std::int32_t, N>;

namespace detail {

/// Counts distinct bins. Open addressing; grows as it fills.
template <class Key>
class BinCounter;

template <std::size_t N>
class BinCounter<BinKey<N>> {
 public:
  /// Counts the bin if it is new, and returns whether it was.
  bool add(const BinKey<N>& key) {
    if (2 * (count_ + 1) > slots_.size()) grow();
    Slot& slot = find(key);
    if (slot.used) return false;
    slot = {key, true};
    ++count_;
    return true;
  }
  [[nodiscard]] std::size_t count() const { return count_; }

 private:
  struct Slot {
    BinKey<N> key{};
    bool used = false;
  };
  Slot& find(const BinKey<N>& key) {
    std::uint64_t hash = 0;
    for (const std::int32_t k : key)
      hash = (hash ^ static_cast<std::uint32_t>(k)) * 0x9e3779b97f4a7c15ULL;
    hash ^= hash >> 32;
    const std::size_t mask = slots_.size() - 1;
    std::size_t i = static_cast<std::size_t>(hash >> 8) & mask;
    while (slots_[i].used && slots_[i].key != key) i = (i + 1) & mask;
    return slots_[i];
  }
  void grow() {
    std::vector<Slot> old(slots_.empty() ? 64 : 2 * slots_.size());
    std::swap(old, slots_);
    for (const Slot& s : old)
      if (s.used) find(s.key) = s;
  }
  std::vector<Slot> slots_;
  std::size_t count_ = 0;
};

template <class Key>
using BinCounterOf = BinCounter<std::remove_cvref_t<Key>>;

}  // namespace detail
}  // namespace wayfare
