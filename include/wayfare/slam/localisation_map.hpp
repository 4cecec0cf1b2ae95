#pragma once

// A known map as localisation reads it: how likely a point of a scan is everywhere, rays, and where
// the robot may be.

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

/// Whose scan it is.
enum class RangeSensor : std::uint8_t { lidar, radar };

/// How a sensor's points lie about what the map has of it.
struct FieldShape {
  /// Of a point about it, m: while the robot is tracked, and while it is searched for, when
  /// particles are farther apart.
  double sigma_m = 0.08;
  double search_sigma_m = 0.25;
  /// Likelihood of a point that fits nothing, against one that fits: larger bears more strangers.
  double floor_probability = 0.05;
};

struct LocalisationMapOptions {
  double occupied_probability = 0.65;  ///< a cell is a wall from here on …
  double free_probability = 0.35;      ///< … and somewhere to be up to here
  double clearance_m = 0.1;            ///< the robot's place keeps this far from walls
  FieldShape lidar{};
  /// Half of a radar's points are clutter, and its bearings are off by a degree or two.
  FieldShape radar{0.08, 0.20, 0.2};
  double seen_probability = 0.9;  ///< a cell of the radar's map shows something from here on
};

/// The map as localisation reads it. Not changed once made; shared by localisers and threads.
class LocalisationMap {
 public:
  /// Of the walls, and where a grid of a radar's detections is given (radar_slam's, or any made by
  /// counting them) of what radar sees as well. An Error where a grid is empty or too large, or has
  /// no wall or nowhere to be.
  [[nodiscard]] static Result<std::shared_ptr<const LocalisationMap>> make(
      const OccupancyGrid& grid, const LocalisationMapOptions& options = {},
      const OccupancyGrid* radar = nullptr);

  [[nodiscard]] const LocalisationMapOptions& options() const { return options_; }
  [[nodiscard]] double resolution_m() const { return fields_[0].sharp.resolution_m(); }
  [[nodiscard]] bool has(RangeSensor sensor) const { return !fields(sensor).sharp.empty(); }
  /// ln p of a point, by sigma_m and by search_sigma_m.
  struct Fields {
    LikelihoodField sharp, broad;
  };
  [[nodiscard]] const Fields& fields(RangeSensor sensor) const {
    return fields_[static_cast<std::size_t>(sensor)];
  }
  [[nodiscard]] const RayCaster& rays() const { return rays_; }
  /// Where the robot may be.
  [[nodiscard]] const std::vector<Cell>& places() const { return places_; }

 private:
  LocalisationMapOptions options_;
  std::array<Fields, 2> fields_;
  RayCaster rays_;
  std::vector<Cell> places_;
};

}  // namespace wayfare
