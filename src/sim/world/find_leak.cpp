#include <algorithm>
#include <cstddef>
#include <deque>
#include <optional>
#include <utility>
#include <vector>

#include <wayfare/core/contract.hpp>
#include <wayfare/sim/floor_plan.hpp>

namespace wayfare::sim {

std::optional<Eigen::Vector2d> find_leak(const FloorPlan& plan, const Eigen::Vector2d& inside_m,
                                         double step_m) {
  WAYFARE_EXPECTS(step_m > 0.0, "the step of the search is positive");
  const Eigen::Vector2d lower = plan.lower_corner_m(), extent = plan.upper_corner_m() - lower;
  const double step = std::max(step_m, extent.maxCoeff() / 4096.0);
  const auto outside = [&](const Eigen::Vector2d& p) {
    return !((p - lower).minCoeff() > 0.0 && (plan.upper_corner_m() - p).minCoeff() > 0.0);
  };
  if (outside(inside_m)) return inside_m;

  // The lattice passes through `inside_m`, so that rounding starts no step on a wall.
  const Eigen::Array2i below = ((inside_m - lower) / step).array().floor().cast<int>();
  const Eigen::Array2i size =
      below + 2 + ((plan.upper_corner_m() - inside_m) / step).array().ceil().cast<int>();
  std::vector<bool> seen(static_cast<std::size_t>(size.x()) * static_cast<std::size_t>(size.y()));
  const auto index = [&](const Eigen::Array2i& c) {
    return static_cast<std::size_t>(c.y()) * static_cast<std::size_t>(size.x()) +
           static_cast<std::size_t>(c.x());
  };
  const auto point = [&](const Eigen::Array2i& c) {
    return Eigen::Vector2d(inside_m + step * (c - below).cast<double>().matrix());
  };
  std::deque<Eigen::Array2i> front{below};
  seen[index(below)] = true;
  while (!front.empty()) {
    const Eigen::Array2i here = front.front();
    front.pop_front();
    for (const auto& [dx, dy] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
      const Eigen::Array2i next = here + Eigen::Array2i(dx, dy);
      const Eigen::Vector2d p = point(next);
      const bool leaves = outside(p);
      if (!leaves && seen[index(next)]) continue;
      if (plan.blocks(point(here), p)) continue;
      if (leaves) return p;
      seen[index(next)] = true;
      front.push_back(next);
    }
  }
  return std::nullopt;
}

}  // namespace wayfare::sim
