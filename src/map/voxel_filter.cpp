#include <wayfare/map/voxel_filter.hpp>

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "map/point_sums.hpp"

namespace wayfare {
namespace detail {

Result<std::vector<Square>> squares_of(const PointSet& points, double side_m) {
  if (!(side_m > 0 && std::isfinite(side_m)))
    return Error{ErrorCode::invalid, "voxel_filter: the side must be positive"};
  std::vector<Square> squares;
  squares.reserve(points.size());
  // Open addressing with linear probing, at most half full: numbers of squares, from 1.
  std::vector<std::uint32_t> table(std::bit_ceil(2 * points.size() + 1));
  const auto entry_of = [&](const Cell& c) -> std::uint32_t& {
    const std::uint64_t key =
        std::uint64_t{static_cast<std::uint32_t>(c.y)} << 32 | static_cast<std::uint32_t>(c.x);
    auto i = static_cast<std::size_t>((key * 0x9e3779b97f4a7c15ULL) >> 32);
    for (;; ++i) {
      std::uint32_t& entry = table[i & (table.size() - 1)];
      if (entry == 0 || squares[entry - 1].at == c) return entry;
    }
  };
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector2d p = points[i].cast<double>();
    const Cell c = cell_of(p, side_m);
    if (!p.allFinite() || std::abs(c.x) >= kMaxCell || std::abs(c.y) >= kMaxCell)
      return Error{ErrorCode::invalid, "voxel_filter: a point is not finite, or too far"};
    std::uint32_t& entry = entry_of(c);
    if (entry == 0) {
      squares.push_back({c});
      entry = static_cast<std::uint32_t>(squares.size());
    }
    Square& square = squares[entry - 1];
    square.sum += p;
    square.points += 1.0;
  }
  return squares;
}

PointSet means_of(const std::vector<Square>& squares) {
  PointSet means;
  means.reserve(squares.size());
  for (const Square& s : squares) means.push_back((s.sum / s.points).cast<float>());
  return means;
}

}  // namespace detail

Result<PointSet> voxel_filter(const PointSet& points, double side_m) {
  const auto squares = detail::squares_of(points, side_m);
  if (!squares) return squares.error();
  return detail::means_of(*squares);
}

}  // namespace wayfare
