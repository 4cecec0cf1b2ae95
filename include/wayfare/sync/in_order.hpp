#pragma once

// Sorts the measurements of a file by time.

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <utility>
#include <vector>

#include <wayfare/core/time.hpp>

namespace wayfare {

/// Irregularities found by sort_by_time().
struct SortReport {
  std::size_t out_of_order = 0;  ///< after a later one
  std::size_t duplicates = 0;    ///< same time as the previous one: dropped
  std::size_t outliers = 0;      ///< far from both neighbours, which are near each other: dropped
};

/// Sorts by `time`; of equal times the first is kept. A stamp further than `reach` from both its
/// neighbours, while they are within `reach` of each other, is taken for damaged; so is the first
/// or last one if it is further than `reach` from the next two.
template <class Measurement>
SortReport sort_by_time(std::vector<Measurement>& all, Duration reach = std::chrono::seconds(60)) {
  SortReport report;
  const auto near = [&](std::size_t i, std::size_t j) {
    const Duration apart = all[i].time - all[j].time;
    return apart <= reach && apart >= -reach;
  };
  const auto is_outlier = [&](std::size_t i) {
    if (all.size() < 3) return false;
    if (i > 0 && i + 1 < all.size())
      return !near(i, i - 1) && !near(i, i + 1) && near(i - 1, i + 1);
    // At an end, compare with the next two.
    const std::size_t a = i == 0 ? 1 : i - 1, b = i == 0 ? 2 : i - 2;
    return !near(i, a) && near(a, b);
  };
  std::vector<bool> drop(all.size());
  for (std::size_t i = 0; i < all.size(); ++i) drop[i] = is_outlier(i);
  std::vector<Measurement> kept;
  kept.reserve(all.size());
  for (std::size_t i = 0; i < all.size(); ++i)
    if (!drop[i]) kept.push_back(std::move(all[i]));
  report.outliers = all.size() - kept.size();
  for (std::size_t i = 1; i < kept.size(); ++i)
    if (kept[i].time < kept[i - 1].time) ++report.out_of_order;
  const auto earlier = [](const Measurement& a, const Measurement& b) { return a.time < b.time; };
  if (report.out_of_order > 0) std::stable_sort(kept.begin(), kept.end(), earlier);
  all.clear();
  for (Measurement& m : kept) {
    if (!all.empty() && all.back().time == m.time) {
      ++report.duplicates;
    } else {
      all.push_back(std::move(m));
    }
  }
  return report;
}

}  // namespace wayfare
