#include "tune/intervals.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

namespace wayfare::fitness_kernels {
namespace {

/// The nodes of an interval and each step's shares of the parabolas through them.
void divide_into_panels(std::span<Step> steps) {
  constexpr double kTwoPanels_s = 0.2;
  const std::size_t n = steps.size();
  std::vector<double> end_s{0.0};
  for (const Step& s : steps) end_s.push_back(end_s.back() + s.imu.dt_s);
  // A parabola is of two panels. One step is a panel by itself.
  const auto wanted = 2 * static_cast<std::size_t>(std::ceil(end_s.back() / kTwoPanels_s));
  const std::size_t panels =
      n == 1 ? 1 : std::min(std::clamp<std::size_t>(wanted, 4, kMostPanels), n - n % 2);
  const auto first_of = [&](std::size_t panel) { return panel * n / panels; };
  for (std::size_t p = 0; p < panels; ++p) {
    for (std::size_t j = first_of(p); j < first_of(p + 1); ++j) {
      Step& s = steps[j];
      s.ends_panel = j + 1 == first_of(p + 1);
      s.ends_interval = j + 1 == n;
      s.first_node = p - p % 2;
      s.shares = {0.0, 1.0, 0.0};
      if (panels == 1) continue;
      const auto node = [&](std::size_t k) { return end_s[first_of(s.first_node + k)]; };
      for (std::size_t k = 0; k < 3; ++k) {
        const double a = node((k + 1) % 3), b = node((k + 2) % 3), t = end_s[j + 1];
        s.shares[k] = (t - a) * (t - b) / ((node(k) - a) * (node(k) - b));
      }
    }
  }
}

}  // namespace

bool divide_into_intervals(std::vector<Step>& steps) {
  constexpr double kLongest_s = 1.0;
  constexpr std::size_t kWorth = 8;  // below, the end of an interval takes longer than its steps
  std::size_t intervals = 0;
  for (std::size_t first = 0, last = 0; first < steps.size(); first = last, ++intervals) {
    double duration_s = 0.0;
    do {
      duration_s += steps[last].imu.dt_s;
      ++last;
    } while (steps[last - 1].satellites == 0 && last < steps.size() &&
             steps[last].plane == steps[first].plane &&
             duration_s + 0.5 * steps[last].imu.dt_s < kLongest_s);
    divide_into_panels(std::span(steps).subspan(first, last - first));
  }
  return steps.size() >= kWorth * intervals;
}

}  // namespace wayfare::fitness_kernels
