#pragma once

// A known map prepared for localisation: likelihood fields of end points, ray casting, and the free
// cells.

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/map/distance_field.hpp>
#include <wayfare/map/likelihood_field.hpp>
#include <wayfare/map/occupancy_grid.hpp>

namespace wayfare {

/// The sensor of a scan.
enum class RangeSensor : std::uint8_t { lidar, radar };

/// Distribution of a sensor's points around the mapped surfaces.
struct FieldShape {
  /// Standard deviation, m: while tracking, and during a search, when particles are sparser.
  double sigma_m = 0.08;
  double search_sigma_m = 0.25;
  /// Likelihood of an outlier relative to a point that fits: larger tolerates more outliers.
  double floor_probability = 0.05;
};

struct LocalisationMapOptions {
  double occupied_probability = 0.65;  ///< least occupancy of a wall
  double free_probability = 0.35;      ///< greatest occupancy of a free cell
  double clearance_m = 0.1;            ///< least distance of the robot's position to walls
  FieldShape lidar{};
  /// Half of a radar's points are clutter, and its bearing error is a degree or two.
  FieldShape radar{0.08, 0.20, 0.2};
  double seen_probability = 0.9;  ///< least occupancy of a reflector in the radar map
};

/// The prepared map. Immutable; shared by localisers and threads.
class LocalisationMap {
 public:
  /// From a grid of the walls and, optionally, a grid of radar detections (of radar_slam, or made
  /// by counting them). Returns an Error if a grid is empty or too large, or has no wall or no free
  /// cell.
  [[nodiscard]] static Result<std::shared_ptr<const LocalisationMap>> make(
      const OccupancyGrid& grid, const LocalisationMapOptions& options = {},
      const OccupancyGrid* radar = nullptr);

  [[nodiscard]] const LocalisationMapOptions& options() const { return options_; }
  [[nodiscard]] double resolution_m() const { return fields_[0].sharp.resolution_m(); }
  [[nodiscard]] bool has(RangeSensor sensor) const { return !fields(sensor).sharp.empty(); }
  /// ln p of a point, with sigma_m and with search_sigma_m.
  struct Fields {
    LikelihoodField sharp, broad;
  };
  [[nodiscard]] const Fields& fields(RangeSensor sensor) const {
    return fields_[static_cast<std::size_t>(sensor)];
  }
  [[nodiscard]] const RayCaster& rays() const { return rays_; }
  /// Cells in which the robot's position may lie.
  [[nodiscard]] const std::vector<Cell>& free_cells() const { return free_cells_; }

 private:
  LocalisationMapOptions options_;
  std::array<Fields, 2> fields_;
  RayCaster rays_;
  std::vector<Cell> free_cells_;
};

}  // namespace wayfare
