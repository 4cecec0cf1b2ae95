#include <wayfare/map/detail/scan_raster.hpp>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <span>
#include <string>

#include "map/kernels/kernels.hpp"
#include "map/raster.hpp"

namespace wayfare {

/// Rows, and parts of 16 columns, of a tile of the raster that a scan can meet.
struct ScanRaster::Window {
  Cell corner;  // of the tile, in the raster
  int first_row, rows, first_part, parts;
};

namespace {

constexpr int kSide = OccupancyGrid::Tiles::kSide;
static_assert(kSide == kernels::kTileSide);

void set(std::vector<std::uint64_t>& bits, std::ptrdiff_t at) {
  bits[static_cast<std::size_t>(at >> 6)] |= std::uint64_t{1} << (at & 63);
}
bool is_set(const std::vector<std::uint64_t>& bits, std::ptrdiff_t at) {
  return (bits[static_cast<std::size_t>(at >> 6)] >> (at & 63) & 1) != 0;
}

template <class T>
void grow(std::vector<T>& values, std::ptrdiff_t size) {
  if (values.size() < static_cast<std::size_t>(size)) values.resize(static_cast<std::size_t>(size));
}

/// Of cells named more than `max` times only that many are kept.
void limit_repeats(std::vector<Cell>& cells, std::size_t max) {
  if (cells.size() <= max) return;
  std::sort(cells.begin(), cells.end());
  std::size_t kept = 0;
  for (const Cell& c : cells)
    if (kept < max || cells[kept - max] != c) cells[kept++] = c;
  cells.resize(kept);
}

/// As kernels::Kernels::count_passes.
kernels::TileExtent count_passes(const kernels::TileDifferences<std::int32_t>& d,
                                 std::uint16_t* passes) {
  kernels::TileExtent extent;
  for (int r = 0; r < d.rows; ++r)
    for (int c = 0; c < 16 * d.parts; ++c) {
      const std::ptrdiff_t at = r * d.stride + c;
      const int column = 16 * d.first_part + c;
      const bool hit = (d.hits[r * (d.stride / kSide)] >> column & 1) != 0;
      d.row_sums[r] += std::exchange(d.along_rows[at], 0);
      d.column_sums[c] += std::exchange(d.along_columns[at], 0);
      const int n = hit ? 0 : std::min(d.row_sums[r] + d.column_sums[c], 0x7fff);
      passes[r * kSide + c] = static_cast<std::uint16_t>(n);
      if (n == 0) continue;
      extent.columns |= std::uint64_t{1} << column;
      extent.rows |= std::uint64_t{1} << r;
    }
  return extent;
}
kernels::TileExtent count_passes(const kernels::TileDifferences<std::int16_t>& d,
                                 std::uint16_t* passes) {
  return kernels::best_kernels().count_passes(d, passes);
}

/// The cells of a window's extent.
CellBox box_of(const kernels::TileExtent& extent, const Cell& corner, int first_row) {
  const auto first = [](std::uint64_t bits) { return std::countr_zero(bits); };
  const auto last = [](std::uint64_t bits) { return 63 - std::countl_zero(bits); };
  return {corner + Cell{first(extent.columns), first_row + first(extent.rows)},
          corner + Cell{last(extent.columns), first_row + last(extent.rows)}};
}

}  // namespace

const std::vector<Eigen::Vector2d>& ScanRaster::directions(const LaserScan& scan) {
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

Result<CellBox> ScanRaster::cover(const SubCellPoint& origin) {
  CellBox& box = box_;
  box = {origin.cell(), origin.cell()};
  for (const Ray& ray : rays_) box.extend(ray.end.cell());
  // Coordinates saturate there.
  if (box.min.x <= -kMaxCell || box.min.y <= -kMaxCell || box.max.x >= kMaxCell ||
      box.max.y >= kMaxCell)
    return Error{ErrorCode::invalid, "the scan lies too far from the map's origin"};
  // Differences are also written right of and above the last cells.
  const Cell low = OccupancyGrid::Tiles::tile_of(box.min);
  const Cell high = OccupancyGrid::Tiles::tile_of(box.max + Cell{1, 1});
  shape_ = {{low.x * kSide, low.y * kSide}, (std::ptrdiff_t{high.x} - low.x + 1) * kSide};
  rows_ = std::ptrdiff_t{box.max.y} - shape_.origin.y + 2;
  if (rows_ > kMaxCells / shape_.stride)
    return Error{ErrorCode::invalid, "the scan spans " + std::to_string(box.width()) + " x " +
                                         std::to_string(box.height()) +
                                         " cells, more than insert_scan supports"};
  return box;
}

void ScanRaster::mark_hits(int max_per_cell) {
  grow(hit_bits_, shape_.stride / 64 * rows_);
  hits_.clear();
  for (const Ray& ray : rays_) {
    if (!ray.hit) continue;
    const Cell cell = ray.end.cell();
    if (max_per_cell == 1 && is_set(hit_bits_, shape_.at(cell))) continue;
    set(hit_bits_, shape_.at(cell));
    hits_.push_back(cell);
  }
  if (max_per_cell > 1) limit_repeats(hits_, static_cast<std::size_t>(max_per_cell));
}

template <class FreeWindow>
void ScanRaster::for_each_window(FreeWindow&& free_window) const {
  const Cell low = box_.min - shape_.origin, high = box_.max + Cell{1, 1} - shape_.origin;
  for (int y = 0; y <= high.y; y += kSide)
    for (int x = 0; x <= high.x; x += kSide) {
      const int first_row = std::max(low.y - y, 0), first_part = std::max(low.x - x, 0) / 16;
      free_window(Window{{x, y},
                         first_row,
                         std::min(high.y - y, kSide - 1) - first_row + 1,
                         first_part,
                         std::min(high.x - x, kSide - 1) / 16 - first_part + 1});
    }
}

template <class Count>
void ScanRaster::free_passed_cells(OccupancyGrid& grid, const SubCellPoint& origin, int max_passes,
                                   LogOdds delta, PassDifferences<Count>& differences) {
  grow(differences.along_rows, shape_.stride * rows_);
  grow(differences.along_columns, shape_.stride * rows_);
  detail::add_segments(origin, std::span<const Ray>(rays_), shape_, differences);
  std::vector<Count> column_sums(static_cast<std::size_t>(shape_.stride), Count{0});
  Count row_sums[kSide];
  alignas(64) std::uint16_t passes[std::size_t{kSide} * kSide];  // of a tile
  for_each_window([&](const Window& w) {
    if (w.corner.x == 0) std::fill(row_sums, row_sums + kSide, Count{0});
    const Cell at = w.corner + Cell{16 * w.first_part, w.first_row};
    const std::ptrdiff_t first = at.y * shape_.stride + at.x;
    const kernels::TileDifferences<Count> window{
        .along_rows = differences.along_rows.data() + first,
        .along_columns = differences.along_columns.data() + first,
        .stride = shape_.stride,
        .rows = w.rows,
        .parts = w.parts,
        .first_part = w.first_part,
        .row_sums = row_sums,
        .column_sums = column_sums.data() + at.x,
        .hits = hit_bits_.data() + (at.y * shape_.stride + w.corner.x) / kSide};
    const auto extent =
        count_passes(window, passes + std::ptrdiff_t{w.first_row} * kSide + 16 * w.first_part);
    if (extent.rows != 0)
      grid.update_tile(box_of(extent, shape_.origin + w.corner, w.first_row), passes, max_passes,
                       delta);
  });
}

void ScanRaster::free_area(OccupancyGrid& grid, const SubCellPoint& origin,
                           const ScanUpdate& update) {
  grow(area_bits_, shape_.stride / kSide * rows_);
  const std::span<const Ray> rays = rays_;
  detail::find_neighbours(rays, origin, update.fill_gap_rad, has_next_);
  detail::fill_polygon(rays, std::span<const std::uint8_t>(has_next_), origin, shape_, rows_,
                       std::span(area_bits_));
  for (std::size_t i = 0; i < rays_.size(); ++i)
    if (has_next_[i] == 0 && has_next_[i == 0 ? rays_.size() - 1 : i - 1] == 0)
      for_each_cell_on_segment(origin, rays_[i].end,
                               [&](const Cell& c) { set(area_bits_, shape_.at(c)); });
  for_each_window([&](const Window& w) {
    kernels::TileExtent extent;
    std::uint64_t bits[kSide];  // of the window's rows
    std::ptrdiff_t at = ((w.corner.y + w.first_row) * shape_.stride + w.corner.x) / kSide;
    for (int r = w.first_row; r < w.first_row + w.rows; ++r, at += shape_.stride / kSide) {
      const auto i = static_cast<std::size_t>(at);
      bits[r] = std::exchange(area_bits_[i], 0) & ~hit_bits_[i];
      extent.columns |= bits[r];
      extent.rows |= std::uint64_t{bits[r] != 0} << r;
    }
    if (extent.rows != 0)
      grid.update_tile(box_of(extent, shape_.origin + w.corner, 0), bits, update.free);
  });
}

Result<void> ScanRaster::apply(OccupancyGrid& grid, const SubCellPoint& origin,
                               const ScanUpdate& update, const FreeSpaceRule& rule) {
  if (rays_.empty()) return {};
  if (const auto covered = cover(origin); !covered) return covered.error();
  mark_hits(rule.max_passes);
  // One scan does not both free and hit a cell.
  if (update.free.fixed != 0) {
    if (rule.fills)
      free_area(grid, origin, update);
    else if (rays_.size() < 0x7fff)
      free_passed_cells(grid, origin, rule.max_passes, update.free, differences_);
    else
      free_passed_cells(grid, origin, rule.max_passes, update.free, wide_differences_);
  }
  for (const Cell& hit : hits_) hit_bits_[static_cast<std::size_t>(shape_.at(hit) >> 6)] = 0;
  if (update.hit.fixed != 0) grid.update(hits_, update.hit);
  return {};
}

}  // namespace wayfare
