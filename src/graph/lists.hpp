#pragma once

#include <concepts>
#include <cstddef>
#include <numeric>
#include <span>
#include <vector>

namespace wayfare::detail {

constexpr std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Many short lists in one array.
template <class T>
class Lists {
 public:
  Lists() = default;
  /// `each(visit)` calls visit(list, item) for all items, list in [0, count), and does the same
  /// when it is called again. Items keep that order.
  Lists(std::size_t count, const auto& each) : starts_(count + 1, 0) {
    each([&](int list, const T&) { ++starts_[at(list) + 1]; });
    std::partial_sum(starts_.begin(), starts_.end(), starts_.begin());
    items_.resize(at(starts_.back()));
    std::vector<int> next(starts_.begin(), starts_.end() - 1);
    each([&](int list, const T& item) { items_[at(next[at(list)]++)] = item; });
  }

  [[nodiscard]] std::size_t count() const { return starts_.size() - 1; }
  [[nodiscard]] std::span<const T> operator[](std::integral auto list) const {
    const auto i = static_cast<std::size_t>(list);
    return std::span(items_).subspan(at(starts_[i]), at(starts_[i + 1] - starts_[i]));
  }

 private:
  std::vector<int> starts_{0};
  std::vector<T> items_;
};

}  // namespace wayfare::detail
