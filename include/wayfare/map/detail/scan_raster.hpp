#pragma once

// Draws the rays of one scan into a raster, which is then added to a grid.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/result.hpp>
#include <wayfare/map/detail/raster.hpp>
#include <wayfare/map/occupancy_grid.hpp>
#include <wayfare/sensors/scans.hpp>

namespace wayfare {

/// How the cells in front of the hits are freed: a type with `static constexpr int
/// kMaxPassesPerCell`, how often one scan may free the same cell, and `bool kFills`, whether the
/// area between neighbouring beams is freed rather than the cells each beam passes.
struct EveryBeam {
  static constexpr int kMaxPassesPerCell = 0x7fff;  ///< once per beam that passes the cell
  static constexpr bool kFills = false;
};
struct OncePerScan {
  static constexpr int kMaxPassesPerCell = 1;  ///< so near cells are not overconfident
  static constexpr bool kFills = false;
};
/// Frees once every cell whose centre is in the polygon of the sensor and the ends of neighbouring
/// beams. Also frees the cells between beams, where a thin object may be missed; several times
/// faster. A beam without a neighbour frees the cells it passes.
struct FillBetweenBeams {
  static constexpr int kMaxPassesPerCell = 1;
  static constexpr bool kFills = true;
};

/// Log-odds added to the freed and the hit cells.
struct ScanUpdate {
  LogOdds free, hit;
  double fill_gap_rad = 0.0;
};

/// Scratch memory of insert_scan; reuse one object. No state is kept between calls.
class ScanRaster {
 public:
  /// Larger scans (a side of 5800 cells, 290 m at 5 cm) are an error.
  static constexpr std::int64_t kMaxCells = std::int64_t{1} << 25;

  struct Ray {
    SubCellPoint end;
    float bearing_rad = 0.0F;  ///< in any frame; used by FillBetweenBeams only
    bool hit = false;
  };

  std::vector<Ray>& rays() { return rays_; }

  /// Unit vectors along the beams, cached for scans of the same geometry.
  const std::vector<Eigen::Vector2d>& directions(const LaserScan& scan);

  /// The cells the rays from `origin` pass. Refused: more than kMaxCells, places that no cell of a
  /// grid can name.
  Result<CellBox> cover(const SubCellPoint& origin);
  /// Refused as by cover; the grid then is as it was.
  template <class FreeSpace>
  Result<void> apply(OccupancyGrid& grid, const SubCellPoint& origin, const ScanUpdate& update);

 private:
  template <class FreeSpace>
  using Mark = std::conditional_t<FreeSpace::kMaxPassesPerCell == 1, std::uint8_t, std::uint16_t>;
  template <class T>
  std::vector<T>& marks() {
    if constexpr (sizeof(T) == 1)
      return once_;
    else
      return counts_;
  }

  template <class FreeSpace>
  void draw(const SubCellPoint& origin, double fill_gap_rad);
  template <class FreeSpace>
  void walk(const Ray& ray, const SubCellPoint& origin);
  template <class FreeSpace>
  void add_hits(OccupancyGrid& grid, LogOdds delta);

  std::vector<Ray> rays_;
  CellBox box_;
  RasterShape shape_;  // whole tiles, from the first that intersects the box
  std::int64_t rows_ = 0;
  std::vector<std::uint8_t> once_;  // zero between calls
  std::vector<std::uint16_t> counts_;
  std::vector<std::uint8_t> has_next_;
  std::vector<Eigen::Vector2d> directions_;
  Angle first_bearing_, bearing_step_;
};

inline const std::vector<Eigen::Vector2d>& ScanRaster::directions(const LaserScan& scan) {
  if (scan.bearings.empty() && directions_.size() == scan.ranges_m.size() &&
      first_bearing_ == scan.first_bearing && bearing_step_ == scan.bearing_step)
    return directions_;
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();  // equal to no bearing
  first_bearing_ = scan.bearings.empty() ? scan.first_bearing : Angle::radians(kNone);
  bearing_step_ = scan.bearing_step;
  directions_.clear();
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    const double bearing = scan.bearing(i).radians();
    directions_.emplace_back(std::cos(bearing), std::sin(bearing));
  }
  return directions_;
}

template <class FreeSpace>
void ScanRaster::walk(const Ray& ray, const SubCellPoint& origin) {
  auto* marks = this->marks<Mark<FreeSpace>>().data();
  if constexpr (FreeSpace::kMaxPassesPerCell == 1) {
    for_each_index_on_segment(origin, ray.end, shape_,
                              [marks](std::ptrdiff_t at, bool) { marks[at] = 1; });
  } else {
    for_each_index_on_segment(origin, ray.end, shape_, [marks](std::ptrdiff_t at, bool is_new) {
      const bool more = is_new && marks[at] < FreeSpace::kMaxPassesPerCell;
      marks[at] = static_cast<std::uint16_t>(marks[at] + (more ? 1 : 0));
    });
  }
}

template <class FreeSpace>
void ScanRaster::draw(const SubCellPoint& origin, double fill_gap_rad) {
  if constexpr (FreeSpace::kFills) {
    const std::span<const Ray> rays = rays_;
    detail::find_neighbours(rays, origin, fill_gap_rad, has_next_);
    detail::fill_polygon(rays, std::span<const std::uint8_t>(has_next_), origin, shape_, rows_,
                         std::span(once_));
    for (std::size_t i = 0; i < rays_.size(); ++i)
      if (has_next_[i] == 0 && has_next_[i == 0 ? rays_.size() - 1 : i - 1] == 0)
        walk<FreeSpace>(rays_[i], origin);
  } else {
    for (const Ray& ray : rays_) walk<FreeSpace>(ray, origin);
  }
  // One scan does not both free and hit a cell.
  auto& marks = this->marks<Mark<FreeSpace>>();
  for (const Ray& ray : rays_)
    if (ray.hit) marks[static_cast<std::size_t>(shape_.at(ray.end.cell()))] = 0;
}

template <class FreeSpace>
void ScanRaster::add_hits(OccupancyGrid& grid, LogOdds delta) {
  auto& marks = this->marks<Mark<FreeSpace>>();
  const auto mark = [&](const Ray& ray) -> Mark<FreeSpace>& {
    return marks[static_cast<std::size_t>(shape_.at(ray.end.cell()))];
  };
  for (const Ray& ray : rays_) {
    if (!ray.hit || mark(ray) == FreeSpace::kMaxPassesPerCell) continue;
    ++mark(ray);
    grid.update(ray.end.cell(), delta);
  }
  for (const Ray& ray : rays_) mark(ray) = 0;
}

inline Result<CellBox> ScanRaster::cover(const SubCellPoint& origin) {
  constexpr int kSide = OccupancyGrid::Tiles::kSide;
  box_ = {origin.cell(), origin.cell()};
  for (const Ray& ray : rays_) box_.extend(ray.end.cell());
  // Coordinates saturate there.
  if (box_.min.x <= -kMaxCell || box_.min.y <= -kMaxCell || box_.max.x >= kMaxCell ||
      box_.max.y >= kMaxCell)
    return Error{ErrorCode::invalid, "the scan lies too far from the map's origin"};
  const Cell low = OccupancyGrid::Tiles::tile_of(box_.min);
  const Cell high = OccupancyGrid::Tiles::tile_of(box_.max);
  shape_ = {{low.x * kSide, low.y * kSide}, (std::ptrdiff_t{high.x} - low.x + 1) * kSide};
  rows_ = std::int64_t{box_.max.y} - shape_.origin.y + 1;
  if (rows_ > kMaxCells / shape_.stride) {
    return Error{ErrorCode::invalid, "the scan spans " + std::to_string(box_.width()) + " x " +
                                         std::to_string(box_.height()) +
                                         " cells, more than insert_scan supports"};
  }
  return box_;
}

template <class FreeSpace>
Result<void> ScanRaster::apply(OccupancyGrid& grid, const SubCellPoint& origin,
                               const ScanUpdate& update) {
  if (rays_.empty()) return {};
  if (const auto box = cover(origin); !box) return box.error();
  auto& marks = this->marks<Mark<FreeSpace>>();
  const auto needed = static_cast<std::size_t>(shape_.stride * rows_);
  if (marks.size() < needed) marks.resize(needed, 0);
  draw<FreeSpace>(origin, update.fill_gap_rad);
  grid.update_marked(box_, marks.data(), shape_.stride, update.free);
  if (update.hit.fixed != 0) add_hits<FreeSpace>(grid, update.hit);
  return {};
}

}  // namespace wayfare
