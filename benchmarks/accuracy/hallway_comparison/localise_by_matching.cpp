#include "localise_by_matching.hpp"

#include <cmath>
#include <utility>

#include <wayfare/map/detail/scan_raster.hpp>
#include <wayfare/map/inverse_lidar.hpp>
#include <wayfare/map/likelihood_field.hpp>
#include <wayfare/match/gauss_newton.hpp>

namespace wayfare::examples {
namespace {

class Localiser {
 public:
  Localiser(const Recording& recording, Sensor sensor, const SE2d& start,
            const MatchingOptions& options)
      : recording_(recording), sensor_(sensor), options_(options), pose_(start), last_(start) {
    run_.map = sensor == Sensor::radar ? OccupancyGrid(detection_map(options.resolution_m))
                                       : OccupancyGrid({.resolution_m = options.resolution_m});
  }

  Result<void> add(const SyncedStep& step) {
    const double rotation = (step.wheels.right_m - step.wheels.left_m) / recording_.wheel_base_m;
    pose_ = pose_.plus({step.forward_m(), 0.0, rotation});
    if (auto done = add_scan(step); !done) return done;
    run_.trajectory.push_back({step.time, Transform2<frame::Map, frame::Base>(pose_)});
    return {};
  }

  [[nodiscard]] MatchingRun run() && { return std::move(run_); }

 private:
  Result<void> add_scan(const SyncedStep& step) {
    const bool lidar = sensor_ == Sensor::lidar && step.laser;
    const bool radar = sensor_ == Sensor::radar && step.radar;
    if ((!lidar && !radar) || !moved()) return {};
    const PointSet points =
        lidar ? end_points(*step.laser, recording_.T_base_laser.raw()) : step.radar->points;
    if (points.size() < options_.fewest_points) {
      ++run_.refused;
      return {};
    }
    if (run_.map.bounds()) {
      if (auto done = match(step.time, points); !done) return done;
    }
    last_ = pose_;
    return lidar ? insert_scan(run_.map, pose_ * recording_.T_base_laser.raw(), *step.laser,
                               InverseLidarModel{}, raster_)
                 : insert_radar(points);
  }

  [[nodiscard]] bool moved() const {
    const Eigen::Vector3d since = pose_.minus(last_);
    return !run_.map.bounds() || since.head<2>().norm() >= options_.match_every_m ||
           std::abs(since.z()) >= options_.match_every.radians();
  }

  Result<void> match(LogTime time, const PointSet& points) {
    const auto grid = view();
    if (!grid) return grid.error();
    const SE2d prior = pose_;
    MatchOptions match;
    match.min_score = options_.min_score;
    const auto found = matcher_.match(*grid, points, prior, options_.window, match);
    if (!found) return found.error();
    if (!*found) {
      ++run_.refused;
      return {};
    }
    ++run_.matched;
    // Between the cells: the rounding to cells would accumulate over the path.
    const auto refined = refine(*grid, points, (*found)->T_map_points);
    if (!refined) return refined.error();
    pose_ = refined->T_map_points;
    if (!run_.surface && time >= options_.surface_at && options_.surface_at > LogTime{})
      return keep_surface(*grid, points);
    return {};
  }

  [[nodiscard]] Result<LikelihoodField> view() const {
    if (sensor_ == Sensor::lidar)
      return likelihood_field(run_.map, {.blur_sigma_m = options_.lidar_blur_m});
    return detection_grid(run_.map, {.hit_probability = options_.radar_hit_probability,
                                     .blur_sigma_m = options_.radar_blur_m});
  }

  // Around the match, at its heading.
  Result<void> keep_surface(const LikelihoodField& grid, const PointSet& points) {
    const SearchWindow window{0.6, 0.6, Angle::degrees(0.0)};
    auto surface = matcher_.surface(grid, points, pose_, window);
    if (!surface) return surface.error();
    run_.surface = std::move(*surface);
    return {};
  }

  // Detections only: radar penetrates objects, so no cell becomes free.
  Result<void> insert_radar(const PointSet& points) {
    const LogOdds hit = LogOdds::from_probability(options_.radar_hit_probability);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector2d p = pose_ * Eigen::Vector2d(points[i].cast<double>());
      run_.map.update(cell_of(p, options_.resolution_m), hit);
    }
    return {};
  }

  const Recording& recording_;
  Sensor sensor_;
  MatchingOptions options_;
  SE2d pose_, last_;
  CorrelativeMatcher matcher_;
  ScanRaster raster_;
  MatchingRun run_;
};

}  // namespace

Result<MatchingRun> localise_by_matching(std::span<const SyncedStep> steps,
                                         const Recording& recording, Sensor sensor,
                                         const SE2d& start, const MatchingOptions& options) {
  Localiser localiser(recording, sensor, start, options);
  for (const SyncedStep& step : steps)
    if (auto done = localiser.add(step); !done) return done.error();
  return std::move(localiser).run();
}

}  // namespace wayfare::examples
