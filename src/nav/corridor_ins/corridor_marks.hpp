#pragma once

#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include <wayfare/match/lines.hpp>

namespace wayfare::corridor {

/// Edges of doors and recesses that were seen from one place of a corridor: a comb, whose shift is
/// the way travelled since. Edges seen later do not enter: their places have the error of the way.
class CorridorMarks {
 public:
  void begin(std::vector<WallEdge> edges) {
    marks_ = std::move(edges);
    missing_ = 0;
  }
  /// Whether tracking is lost: no mark was found in three consecutive scans.
  [[nodiscard]] bool are_passed() const { return missing_ >= 3; }

  /// The position of the laser along the corridor less `predicted_m`, and its standard deviation.
  struct Shift {
    double shift_m, sigma_m;
  };
  /// From the marks that agree, of the largest group. Nothing without one.
  [[nodiscard]] std::optional<Shift> match(const std::vector<WallEdge>& edges, double predicted_m) {
    constexpr double kAgree_m = 0.08;
    std::vector<Shift> shifts;
    for (const WallEdge& edge : edges)
      if (const WallEdge* mark = nearest(edge, predicted_m + edge.along_m))
        shifts.push_back(
            {mark->along_m - predicted_m - edge.along_m, std::hypot(edge.sigma_m, mark->sigma_m)});
    missing_ = shifts.empty() ? missing_ + 1 : 0;
    std::optional<Shift> best;
    std::size_t most = 0;
    for (const Shift& center : shifts) {
      double sum = 0.0, weight = 0.0;
      std::size_t n = 0;
      for (const Shift& s : shifts) {
        if (std::abs(s.shift_m - center.shift_m) > kAgree_m) continue;
        const double w = 1.0 / (s.sigma_m * s.sigma_m);
        sum += w * s.shift_m, weight += w, ++n;
      }
      if (n > most) most = n, best = Shift{sum / weight, 1.0 / std::sqrt(weight)};
    }
    return best;
  }

 private:
  /// Of the same kind, within reach.
  [[nodiscard]] const WallEdge* nearest(const WallEdge& edge, double along_m) const {
    constexpr double kReach_m = 0.25;
    const WallEdge* best = nullptr;
    double least = kReach_m;
    for (const WallEdge& mark : marks_) {
      const double d = std::abs(mark.along_m - along_m);
      if (mark.left != edge.left || mark.gap_ahead != edge.gap_ahead || d > least) continue;
      least = d, best = &mark;
    }
    return best;
  }

  std::vector<WallEdge> marks_;
  int missing_ = 0;
};

}  // namespace wayfare::corridor
