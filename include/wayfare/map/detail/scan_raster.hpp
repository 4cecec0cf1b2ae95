#pragma once

// Draws the rays of one scan into a raster, which is then added to a grid.

#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/map/detail/raster_shape.hpp>
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

/// How many segments pass each cell of a raster, as differences of neighbours: those of flat
/// segments along rows, those of steep ones along columns.
template <class Count>
struct PassDifferences {
  std::vector<Count> along_rows, along_columns;
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
  /// Draws the rays and adds them to the grid. Refused as by cover; the grid then is as it was.
  template <class FreeSpace>
  Result<void> apply(OccupancyGrid& grid, const SubCellPoint& origin, const ScanUpdate& update) {
    return apply(grid, origin, update, {FreeSpace::kMaxPassesPerCell, FreeSpace::kFills});
  }

 private:
  struct FreeSpaceRule {
    int max_passes;
    bool fills;
  };
  struct Window;

  Result<void> apply(OccupancyGrid& grid, const SubCellPoint& origin, const ScanUpdate& update,
                     const FreeSpaceRule& rule);
  void mark_hits(int max_per_cell);
  template <class Count>
  void free_passed_cells(OccupancyGrid& grid, const SubCellPoint& origin, int max_passes,
                         LogOdds delta, PassDifferences<Count>& differences);
  void free_area(OccupancyGrid& grid, const SubCellPoint& origin, const ScanUpdate& update);
  template <class FreeWindow>
  void for_each_window(FreeWindow&& free_window) const;

  std::vector<Ray> rays_;
  CellBox box_;
  RasterShape shape_;  // whole tiles, from the first that a ray meets
  std::ptrdiff_t rows_ = 0;
  // Zero between calls. Bits are one for each cell.
  PassDifferences<std::int16_t> differences_;
  PassDifferences<std::int32_t> wide_differences_;
  std::vector<std::uint64_t> hit_bits_, area_bits_;
  // No state is kept in these.
  std::vector<Cell> hits_;
  std::vector<std::uint8_t> has_next_;
  std::vector<Eigen::Vector2d> directions_;
  Angle first_bearing_, bearing_step_;
};

}  // namespace wayfare
