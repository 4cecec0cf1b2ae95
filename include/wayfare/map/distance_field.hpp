#pragma once

// The distance from every cell of a map to the nearest obstacle, and its uses: likelihood fields
// and ray casting by sphere tracing.

#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include <wayfare/core/detail/reset_on_move.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/map/cell.hpp>
#include <wayfare/map/likelihood_field.hpp>
#include <wayfare/map/occupancy_grid.hpp>

namespace wayfare {

/// The exact Euclidean distance between the centres of each cell and of the nearest occupied one,
/// as a squared number of cells. Immutable; a moved-from field is empty.
class DistanceField {
 public:
  /// Largest number of cells along a side …
  static constexpr int kMaxSide = 29000;
  /// … and in total.
  static constexpr std::int64_t kMaxCells = std::int64_t{1} << 26;
  /// Value of every cell if none is occupied.
  static constexpr std::int32_t kFar = 900'000'000;

  DistanceField() = default;

  /// From a mask, row by row from the lowest, occupied where not zero; its first cell is `origin`.
  /// Errors: sizes that do not agree or are too large, a resolution that is not positive, an origin
  /// beyond ±kMaxCell.
  [[nodiscard]] static Result<DistanceField> of_mask(std::span<const std::uint8_t> occupied,
                                                     int width, int height, double resolution_m,
                                                     const Cell& origin = {});

  /// From the cells with at least this probability of being occupied, over the grid's bounds.
  /// Errors: no observed cell, bounds that are too large, a probability outside [0, 1].
  [[nodiscard]] static Result<DistanceField> of_grid(const OccupancyGrid& grid,
                                                     double occupied_probability = 0.65);

  /// Side of a cell, m.
  [[nodiscard]] double resolution_m() const { return resolution_m_; }
  /// The map cell at column 0 of row 0.
  [[nodiscard]] const Cell& origin() const { return origin_; }
  /// Columns.
  [[nodiscard]] int width() const { return width_; }
  /// Rows.
  [[nodiscard]] int height() const { return height_; }
  /// Whether it has no cells.
  [[nodiscard]] bool empty() const { return width_ == 0; }

  /// One row; the first cell is at the origin.
  [[nodiscard]] std::span<const std::int32_t> row(int r) const {
    const auto stride = static_cast<std::size_t>(stride_), w = static_cast<std::size_t>(width_);
    return std::span(squared_).subspan(static_cast<std::size_t>(r) * stride, w);
  }
  /// kFar outside the field.
  [[nodiscard]] std::int32_t squared_cells(const Cell& map_cell) const {
    const Cell c = map_cell - origin_;
    if (c.x < 0 || c.y < 0 || c.x >= width_ || c.y >= height_) return kFar;
    return row(c.y)[static_cast<std::size_t>(c.x)];
  }
  /// Metres; infinite if no cell is occupied, and outside the field.
  [[nodiscard]] double distance_m(const Cell& map_cell) const {
    const std::int32_t square = squared_cells(map_cell);
    return square >= kFar ? std::numeric_limits<double>::infinity()
                          : resolution_m_ * std::sqrt(static_cast<double>(square));
  }

 private:
  double resolution_m_ = 0.05;
  Cell origin_;
  ResetOnMove<int> width_, height_;
  int stride_ = 0;
  std::vector<std::int32_t> squared_;
};

/// ln p = ln(floor + (1 − floor)·exp(−d²/2σ²)) of the distance d to the nearest obstacle: the
/// likelihood field of a known map (Thrun, Burgard and Fox 2005, 6.4), scaled so that a point on a
/// wall has p = 1. Points outside the map have the floor.
struct DistanceLikelihood {
  /// Standard deviation of a point about the wall it measures, m; larger values widen the basin of
  /// attraction.
  double sigma_m = 0.1;
  /// Of a point far from every wall, such as on people and objects that are not in the map.
  double floor_probability = 0.05;
};
/// The likelihood field of a map's distances. Errors: an empty field, likelihood values out of
/// range.
[[nodiscard]] Result<LikelihoodField> likelihood_field(const DistanceField& distances,
                                                       const DistanceLikelihood& likelihood = {});

/// Expected ranges of a sensor in the map, sixteen rays at a time. A moved-from caster has no
/// cells, as a default one.
class RayCaster {
 public:
  /// Longest ray, cells.
  static constexpr double kMaxCells = 8000.0;

  RayCaster() = default;
  /// Copies what it needs of the field.
  explicit RayCaster(const DistanceField& distances);

  /// Ranges from the pose along its heading plus each bearing, given by cosines and sines: metres
  /// to where the ray enters the first occupied cell, 0 from inside one, `max_range_m` if there is
  /// none within it or the ray leaves the map first, or if the pose is not finite. A cell may be
  /// missed if the ray passes within a thousandth of a cell of its corner. Ranges end at kMaxCells;
  /// a `max_range_m` that is not positive gives zeros. The three spans have the same length.
  void cast(const SE2d& T_map_laser, std::span<const float> cosines, std::span<const float> sines,
            double max_range_m, std::span<float> ranges_m) const;

 private:
  double resolution_m_ = 0.05;
  Cell origin_;
  ResetOnMove<int> width_, height_;
  std::vector<float> distance_ = std::vector<float>(4, -1.0F);  // with a border of −1
};

}  // namespace wayfare
