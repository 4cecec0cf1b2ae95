#pragma once

// Messages whose values follow from a number alone, so that two programs agree on them without a
// common library. C++17, as the headers of Fast DDS are.

#include <array>
#include <cstddef>
#include <cstdint>
#include <sstream>
#include <string>
#include <type_traits>
#include <vector>

namespace peer {

/// Visits the fields of a message in the order of its definition: sets them, or compares them.
/// `Members::each(formula, message)` visits the fields of a struct.
template <class Members>
class Formula {
 public:
  /// Of the sample with this number; sequences have at least `size` elements.
  Formula(std::uint32_t sample, std::uint32_t size, bool compares)
      : sample_(sample), size_(size), compares_(compares) {}

  template <class T>
  void operator()(T& value) {
    if (!difference_.empty()) return;
    if constexpr (std::is_same_v<T, bool>) {
      settle(value, (next() & 1U) != 0);
    } else if constexpr (std::is_floating_point_v<T>) {
      // Exact in single precision, too.
      settle(value, static_cast<T>(static_cast<int>(next() % 2'000'001U) - 1'000'000) / T(64));
    } else if constexpr (std::is_integral_v<T>) {
      settle(value, static_cast<T>(next()));
    } else {
      Members::each(*this, value);
    }
  }
  void operator()(std::string& text) {
    if (!difference_.empty()) return;
    const std::uint32_t n = next();
    settle(text, std::string(n % 12U, static_cast<char>('a' + n % 26U)));
  }
  template <class T>
  void operator()(std::vector<T>& list) {
    std::size_t size = size_ + next() % 9U;
    if (compares_) {
      std::size_t got = list.size();
      settle(got, size);
    } else {
      list.resize(size);
    }
    if (!difference_.empty()) return;
    for (std::size_t i = 0; i < size; ++i) (*this)(list[i]);
  }
  template <class T, std::size_t N>
  void operator()(std::array<T, N>& list) {
    for (T& item : list) (*this)(item);
  }

  /// The first value that differs, with its number; empty if none does.
  [[nodiscard]] const std::string& difference() const { return difference_; }

 private:
  /// The next value of a sequence that depends on the sample alone.
  std::uint32_t next() {
    std::uint32_t x = 0x9e3779b9U * (sample_ + 1U) + 0x85ebca6bU * ++leaf_;
    x = (x ^ (x >> 16U)) * 0x7feb352dU;
    x = (x ^ (x >> 15U)) * 0x846ca68bU;
    return x ^ (x >> 16U);
  }
  template <class T>
  void settle(T& value, const T& wanted) {
    if (!compares_) {
      value = wanted;
    } else if (!(value == wanted)) {
      std::ostringstream text;
      text << "value " << leaf_ << " is " << +value << ", not " << +wanted;
      difference_ = text.str();
    }
  }
  void settle(std::string& value, const std::string& wanted) {
    if (!compares_)
      value = wanted;
    else if (value != wanted)
      difference_ = "text " + std::to_string(leaf_) + " is '" + value + "', not '" + wanted + "'";
  }
  std::uint32_t sample_, size_, leaf_ = 0;
  bool compares_;
  std::string difference_;
};

}  // namespace peer
