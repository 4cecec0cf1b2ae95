#include <cmath>
#include <numbers>
#include <vector>

#include "match/lines/candidates.hpp"

namespace wayfare::lines {
namespace {

constexpr double kPeak_rad = 2.5 * std::numbers::pi / 180.0;

struct Weighted {
  double off_rad, weight_m;
};

/// The entry with the greatest weight about it; null if there are none.
const Weighted* peak_of(const std::vector<Weighted>& entries) {
  const Weighted* best = nullptr;
  double greatest = 0.0;
  for (const Weighted& center : entries) {
    double sum = 0.0;
    for (const Weighted& e : entries)
      if (std::abs(e.off_rad - center.off_rad) < kPeak_rad) sum += e.weight_m;
    if (sum > greatest) greatest = sum, best = &center;
  }
  return best;
}

}  // namespace

std::optional<SquareDirection> square_direction(std::span<const Segment> segments, Angle near,
                                                Angle within, double min_support_m) {
  std::vector<Weighted> entries;
  double total = 0.0;
  for (const Segment& s : segments) {
    const double off =
        std::remainder(std::atan2(s.uy, s.ux) - near.radians(), 0.5 * std::numbers::pi);
    total += s.weight_m;
    if (std::abs(off) <= within.radians()) entries.push_back({off, s.weight_m});
  }
  const Weighted* peak = peak_of(entries);
  if (peak == nullptr) return {};
  double n = 0.0, sum = 0.0, sum2 = 0.0;
  for (const Weighted& e : entries) {
    const double off = e.off_rad - peak->off_rad;
    if (std::abs(off) >= kPeak_rad) continue;
    n += e.weight_m, sum += e.weight_m * off, sum2 += e.weight_m * off * off;
  }
  if (n < min_support_m) return {};
  const double mean = sum / n;
  return SquareDirection{Angle::radians(near.radians() + peak->off_rad + mean).wrapped(), n, total,
                         std::sqrt(std::max(sum2 / n - mean * mean, 0.0))};
}

}  // namespace wayfare::lines
