#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

namespace wayfare::eval {

/// What is said of a set of errors, in the errors' unit; NaN where there are none.
struct Summary {
  std::size_t count = 0;
  double mean = std::numeric_limits<double>::quiet_NaN();
  double std = std::numeric_limits<double>::quiet_NaN();  ///< of the population: divided by count
  double rmse = std::numeric_limits<double>::quiet_NaN();
  double median = std::numeric_limits<double>::quiet_NaN();  ///< mean of the middle two if even
  double max = std::numeric_limits<double>::quiet_NaN();
};

[[nodiscard]] inline double median_of(std::vector<double> values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

[[nodiscard]] inline Summary summarise(std::span<const double> values) {
  Summary s;
  s.count = values.size();
  if (values.empty()) return s;
  const auto n = static_cast<double>(values.size());
  double sum = 0.0, squares = 0.0, spread = 0.0;
  for (const double v : values) sum += v, squares += v * v;
  s.mean = sum / n;
  for (const double v : values) spread += (v - s.mean) * (v - s.mean);
  s.std = std::sqrt(spread / n);
  s.rmse = std::sqrt(squares / n);
  s.median = median_of({values.begin(), values.end()});
  s.max = *std::max_element(values.begin(), values.end());
  return s;
}

}  // namespace wayfare::eval
