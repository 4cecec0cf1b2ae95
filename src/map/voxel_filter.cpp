#include <wayfare/map/voxel_filter.hpp>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include <wayfare/map/cell.hpp>

namespace wayfare {

Result<PointSet> voxel_filter(const PointSet& points, double side_m) {
  if (!(side_m > 0 && std::isfinite(side_m)))
    return Error{ErrorCode::invalid, "voxel_filter: the side must be positive"};
  struct Square {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    double points = 0.0;
  };
  std::vector<Square> squares;
  std::unordered_map<std::int64_t, std::size_t> square_at;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector2d p = points[i].cast<double>();
    const Cell c = cell_of(p, side_m);
    if (!p.allFinite() || std::abs(c.x) >= kMaxCell || std::abs(c.y) >= kMaxCell)
      return Error{ErrorCode::invalid, "voxel_filter: a point is not finite, or too far"};
    const std::int64_t key = std::int64_t{c.y} * (std::int64_t{1} << 32) + c.x;
    const auto [entry, is_new] = square_at.try_emplace(key, squares.size());
    if (is_new) squares.emplace_back();
    Square& square = squares[entry->second];
    square.sum += p;
    square.points += 1.0;
  }
  PointSet filtered;
  filtered.reserve(squares.size());
  for (const Square& s : squares) filtered.push_back((s.sum / s.points).cast<float>());
  return filtered;
}

}  // namespace wayfare
