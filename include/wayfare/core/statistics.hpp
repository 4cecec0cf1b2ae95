#pragma once

// Summary statistics, and the chi-square distribution of squared, normalised errors.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <ranges>
#include <span>
#include <type_traits>
#include <vector>

#include <wayfare/core/contract.hpp>

namespace wayfare {

/// Statistics of a set of errors, in the errors' unit; NaN where there are none, or one is NaN.
struct Summary {
  std::size_t count = 0;                                   ///< number of errors
  double mean = std::numeric_limits<double>::quiet_NaN();  ///< arithmetic
  double std = std::numeric_limits<double>::quiet_NaN();   ///< of the population: divided by count
  double rmse = std::numeric_limits<double>::quiet_NaN();  ///< root mean square
  double median = std::numeric_limits<double>::quiet_NaN();  ///< mean of the middle two if even
  double max = std::numeric_limits<double>::quiet_NaN();     ///< the largest
};

namespace detail {
[[nodiscard]] inline bool any_nan(std::span<const double> values) {
  return std::any_of(values.begin(), values.end(), [](double v) { return v != v; });
}
}  // namespace detail

/// NaN if there are none, or one of them is NaN.
[[nodiscard]] inline double median_of(std::vector<double> values) {
  if (values.empty() || detail::any_nan(values)) return std::numeric_limits<double>::quiet_NaN();
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

/// The value below which the share `part`, in [0, 1], of them lies, without interpolation; NaN if
/// there are none, or one of them is NaN.
[[nodiscard]] inline double quantile(std::vector<double> values, double part) {
  WAYFARE_EXPECTS(part >= 0.0 && part <= 1.0, "the share must be in [0, 1]");
  if (values.empty() || detail::any_nan(values)) return std::numeric_limits<double>::quiet_NaN();
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(part * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// The median of the projected values, of an even number the greater of the middle two, of none a
/// zero. Reorders the values, which must not be NaN.
template <std::ranges::random_access_range Values, class Projection = std::identity>
[[nodiscard]] auto upper_median_of(Values&& values, Projection projection = {}) {
  using Value = std::remove_cvref_t<
      std::invoke_result_t<Projection&, std::ranges::range_reference_t<Values>>>;
  if (std::ranges::empty(values)) return Value{};
  const auto middle = std::ranges::begin(values) + std::ranges::ssize(values) / 2;
  std::ranges::nth_element(values, middle, {}, projection);
  return Value(std::invoke(projection, *middle));
}

/// Statistics of the values; NaN and a count of zero without any.
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
  s.max = s.mean == s.mean || !detail::any_nan(values)
              ? *std::max_element(values.begin(), values.end())
              : std::numeric_limits<double>::quiet_NaN();
  return s;
}

namespace detail {

// Of a positive number.
inline double log_gamma(double a) {
  return std::lgamma(a);  // NOLINT(concurrency-mt-unsafe): another thread changes the sign it
                          // stores, not the result
}

// Regularised lower incomplete gamma function by its power series (Abramowitz and Stegun 1964,
// 6.5.29): converges quickly for x < a + 1.
inline double gamma_p_series(double a, double x) {
  double term = 1.0 / a, sum = term;
  for (double n = a + 1.0; term > sum * 1e-17; n += 1.0) sum += term *= x / n;
  return sum * std::exp(a * std::log(x) - x - log_gamma(a));
}

// The upper one by its continued fraction (6.5.31), by Lentz's forward method: for x ≥ a + 1.
inline double gamma_q_fraction(double a, double x) {
  double b = x + 1.0 - a, c = 1e300, d = 1.0 / b, h = d, factor = 0.0;
  for (double i = 1.0; std::abs(factor - 1.0) > 1e-16 && i < 1e5; i += 1.0) {
    const double numerator = -i * (i - a);
    b += 2.0;
    d = 1.0 / (b + numerator * d);
    c = b + numerator / c;
    factor = c * d;
    h *= factor;
  }
  return h * std::exp(a * std::log(x) - x - log_gamma(a));
}

}  // namespace detail

/// Probability that the sum of squares of `dof` standard normal numbers is below `x`.
[[nodiscard]] inline double chi_square_probability(double x, double dof) {
  WAYFARE_EXPECTS(dof > 0.0,
                  "a chi-square distribution has a positive number of degrees of freedom");
  if (!(x > 0.0)) return x == x ? 0.0 : x;
  if (std::isinf(x)) return 1.0;
  // The expansions need a number of terms that grows with the root of `dof`. For so many degrees of
  // freedom the cube root of x / dof is normal, to about 1/dof (Wilson and Hilferty 1931).
  constexpr double kMany = 1e9;
  if (dof > kMany) {
    const double variance = 2.0 / (9.0 * std::min(dof, std::numeric_limits<double>::max()));
    const double normal = (std::cbrt(x / dof) - (1.0 - variance)) / std::sqrt(variance);
    return 0.5 * std::erfc(-normal / std::sqrt(2.0));
  }
  const double a = 0.5 * dof, y = 0.5 * x;
  return y < a + 1.0 ? detail::gamma_p_series(a, y) : 1.0 - detail::gamma_q_fraction(a, y);
}

/// The inverse of chi_square_probability at `p` in [0, 1).
[[nodiscard]] inline double chi_square_quantile(double p, double dof) {
  WAYFARE_EXPECTS(p >= 0.0 && p < 1.0, "the probability must be in [0, 1)");
  if (p == 0.0) return 0.0;
  double low = 0.0, high = dof + 1.0;
  while (chi_square_probability(high, dof) < p) low = high, high *= 2.0;
  while (high - low > 4.0 * std::numeric_limits<double>::epsilon() * high) {
    const double middle = 0.5 * (low + high);
    if (!(middle > low && middle < high)) break;  // no double between them, as near zero
    (chi_square_probability(middle, dof) < p ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace wayfare
