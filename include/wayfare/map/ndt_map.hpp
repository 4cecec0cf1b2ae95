#pragma once

// Normal distributions of the points of scans, on squares.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/result.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/map/cell.hpp>
#include <wayfare/map/likelihood_field.hpp>
#include <wayfare/sensors/point_set.hpp>

namespace wayfare {

/// Squares and distributions of an NdtMap.
struct NdtMapOptions {
  /// Sides of the squares, coarse to fine, m.
  std::vector<double> cell_sizes_m{2.0, 1.0, 0.5};
  /// Squares with fewer points have no distribution. At least 1.
  int min_points = 5;
  /// Lower bound of a distribution's standard deviations, m: the noise of a point. At least 1e-6.
  double min_sigma_m = 0.03;
};

/// Normal distribution of the points of one square.
struct NdtCell {
  Eigen::Vector2d mean;         ///< m, map coordinates
  Eigen::Matrix2d information;  ///< inverse covariance
  bool known = false;           ///< false with too few points
};

/// The normal distributions transform of scans (Biber and Straßer 2003): for each cell size four
/// tilings, shifted by half a square, so that every point is well inside a square of one of them.
class NdtMap {
 public:
  NdtMap() = default;

  /// Errors: no points, points or poses that are not finite, points too far apart (more than 2²⁴
  /// squares about the origin would contain them), cell sizes that are not positive, options out of
  /// range.
  [[nodiscard]] static Result<NdtMap> make(std::span<const PlacedPoints> scans,
                                           const NdtMapOptions& options = {});

  /// Σ over the four tilings and the points p of a scan, placed by a pose R, t: e = exp(−½ dᵀΛd) of
  /// the offsets d = R p + t − µ, and its terms of a Gauss-Newton step in the map's axes.
  struct Sums {
    double likelihood = 0.0;                            ///< Σ e
    Eigen::Vector3d pull = Eigen::Vector3d::Zero();     ///< Σ e JᵀΛd, J = ∂d/∂(t, θ)
    Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();  ///< Σ e JᵀΛJ
  };

  /// The tilings of one cell size.
  class Level {
   public:
    /// Of at least one point.
    Level(const PointSet& points_map, double cell_m, const NdtMapOptions& options);
    static constexpr int kTilings = 4;  ///< shifts by half a square along x, y and both
    /// The distribution at a point in tiling `t`, or null.
    [[nodiscard]] const NdtCell* at(const Eigen::Vector2d& p_map, int t) const {
      const Cell c = cell_of(p_map + shift(t), cell_m_);
      if (!box_.contains(c)) return nullptr;
      const NdtCell& cell =
          cells_[static_cast<std::size_t>(places_[static_cast<std::size_t>(t)][place(c)])];
      return cell.known ? &cell : nullptr;
    }
    /// Of the points at a pose, in single precision relative to it.
    [[nodiscard]] Sums sums(const PointSet& points, const SE2d& T_map_points) const;

   private:
    [[nodiscard]] Eigen::Vector2d shift(int t) const {
      return 0.5 * cell_m_ * Eigen::Vector2d(t & 1, t >> 1);
    }
    /// Of a square, row-major with a border of one.
    [[nodiscard]] std::size_t place(const Cell& c) const { return box_.grown(1).index(c); }

    double cell_m_;
    CellBox box_;
    std::vector<std::vector<std::int32_t>> places_;  // of each tiling's squares, in cells_
    std::vector<NdtCell> cells_;                     // the first is unknown
    std::vector<float> packed_;                      // cells_ as kernels::NdtTable has them
  };

  /// Whether it has no points.
  [[nodiscard]] bool empty() const { return levels_.empty(); }
  /// Coarse to fine.
  [[nodiscard]] std::span<const Level> levels() const { return levels_; }

 private:
  std::vector<Level> levels_;
};

}  // namespace wayfare
