#pragma once

// Measurements as they stand in a file, put in order of time.

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <utility>
#include <vector>

#include <wayfare/core/time.hpp>

namespace wayfare {

/// What putting measurements in order found.
struct OrderReport {
  std::size_t swapped = 0;   ///< stood behind a later one
  std::size_t repeated = 0;  ///< the time of the one before again: left out
  std::size_t astray = 0;    ///< far from both neighbours, which are near each other: left out
};

/// Sorts by `time`; of several with one time the first stays. A stamp further than `reach` from
/// both its neighbours, while they are within it of each other, is taken for a damaged one; so is a
/// first or last one that stands alone before the others' earliest or behind their latest.
template <class Measurement>
OrderReport put_in_order(std::vector<Measurement>& all, Duration reach = std::chrono::seconds(60)) {
  OrderReport report;
  const auto near = [&](std::size_t i, std::size_t j) {
    const Duration apart = all[i].time - all[j].time;
    return apart <= reach && apart >= -reach;
  };
  const auto astray = [&](std::size_t i) {
    if (all.size() < 3) return false;
    if (i > 0 && i + 1 < all.size())
      return !near(i, i - 1) && !near(i, i + 1) && near(i - 1, i + 1);
    // At an end the two next to it speak for each other.
    const std::size_t a = i == 0 ? 1 : i - 1, b = i == 0 ? 2 : i - 2;
    return !near(i, a) && near(a, b);
  };
  std::vector<bool> leave_out(all.size());
  for (std::size_t i = 0; i < all.size(); ++i) leave_out[i] = astray(i);
  std::vector<Measurement> kept;
  kept.reserve(all.size());
  for (std::size_t i = 0; i < all.size(); ++i)
    if (!leave_out[i]) kept.push_back(std::move(all[i]));
  report.astray = all.size() - kept.size();
  for (std::size_t i = 1; i < kept.size(); ++i)
    if (kept[i].time < kept[i - 1].time) ++report.swapped;
  const auto earlier = [](const Measurement& a, const Measurement& b) { return a.time < b.time; };
  if (report.swapped > 0) std::stable_sort(kept.begin(), kept.end(), earlier);
  all.clear();
  for (Measurement& m : kept) {
    if (!all.empty() && all.back().time == m.time) {
      ++report.repeated;
    } else {
      all.push_back(std::move(m));
    }
  }
  return report;
}

}  // namespace wayfare
