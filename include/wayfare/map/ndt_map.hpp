#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/result.hpp>
#include <wayfare/map/cell.hpp>
#include <wayfare/map/likelihood_field.hpp>

namespace wayfare {

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
  Eigen::Vector2d mean;
  Eigen::Matrix2d information;  ///< inverse covariance
  bool known = false;
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

  /// The tilings of one cell size.
  class Level {
   public:
    /// Of at least one point.
    Level(const PointSet& points_map, double cell_m, const NdtMapOptions& options);
    static constexpr int kTilings = 4;
    /// The distribution at a point in tiling `t`, or null.
    [[nodiscard]] const NdtCell* at(const Eigen::Vector2d& p_map, int t) const {
      const Cell c = cell_of(p_map + shift(t), cell_m_);
      if (!box_.contains(c)) return nullptr;
      const std::uint32_t i = places_[static_cast<std::size_t>(t)][box_.index(c)];
      return i == kNone ? nullptr : &cells_[i];
    }

   private:
    [[nodiscard]] Eigen::Vector2d shift(int t) const {
      return 0.5 * cell_m_ * Eigen::Vector2d(t & 1, t >> 1);
    }
    static constexpr std::uint32_t kNone = 0xffffffff;

    double cell_m_;
    CellBox box_;
    std::vector<std::vector<std::uint32_t>> places_;  // of each tiling's squares, in cells_
    std::vector<NdtCell> cells_;
  };

  [[nodiscard]] bool empty() const { return levels_.empty(); }
  [[nodiscard]] std::span<const Level> levels() const { return levels_; }

 private:
  std::vector<Level> levels_;
};

}  // namespace wayfare
