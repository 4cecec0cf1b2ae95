#include <wayfare/map/voxel_filter.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <wayfare/map/cell.hpp>

namespace wayfare {
namespace {

struct Entry {
  std::int64_t square;
  std::uint32_t point;
};

Result<std::vector<Entry>> by_square(const PointSet& points, double side_m) {
  std::vector<Entry> entries;
  entries.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector2d p = points[i].cast<double>();
    const Cell c = cell_of(p, side_m);
    if (!p.allFinite() || std::abs(c.x) >= kMaxCell || std::abs(c.y) >= kMaxCell)
      return Error{ErrorCode::invalid, "voxel_filter: a point is not finite, or too far"};
    entries.push_back(
        {std::int64_t{c.y} * (std::int64_t{1} << 32) + c.x, static_cast<std::uint32_t>(i)});
  }
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    return a.square != b.square ? a.square < b.square : a.point < b.point;
  });
  return entries;
}

struct Mean {
  std::uint32_t first;
  Eigen::Vector2f point;
};

}  // namespace

Result<PointSet> voxel_filter(const PointSet& points, double side_m) {
  if (!(side_m > 0 && std::isfinite(side_m)))
    return Error{ErrorCode::invalid, "voxel_filter: the side must be positive"};
  const auto entries = by_square(points, side_m);
  if (!entries) return entries.error();
  std::vector<Mean> means;
  for (auto begin = entries->begin(); begin != entries->end();) {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    auto end = begin;
    for (; end != entries->end() && end->square == begin->square; ++end)
      sum += points[end->point].cast<double>();
    means.push_back({begin->point, (sum / static_cast<double>(end - begin)).cast<float>()});
    begin = end;
  }
  std::sort(means.begin(), means.end(),
            [](const Mean& a, const Mean& b) { return a.first < b.first; });
  PointSet filtered;
  filtered.reserve(means.size());
  for (const Mean& m : means) filtered.push_back(m.point);
  return filtered;
}

}  // namespace wayfare
