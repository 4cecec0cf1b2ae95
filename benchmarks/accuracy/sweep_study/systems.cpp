#include "systems.hpp"

#include <wayfare/sim/floor_plan.hpp>
#include <wayfare/slam/graph_slam.hpp>
#include <wayfare/slam/hector_slam.hpp>
#include <wayfare/slam/localisation.hpp>
#include <wayfare/slam/radar_slam.hpp>
#include <wayfare/slam/run_localisation.hpp>
#include <wayfare/slam/submap_slam.hpp>

namespace wayfare::examples {
namespace {

template <class Run>
Result<Trajectory> trajectory_of(const Result<Run>& run) {
  return run ? Result<Trajectory>(run->trajectory) : run.error();
}

Recording without_odometry(Recording recording, bool gyro) {
  recording.odometry.clear();
  if (!gyro) recording.gyro.clear();
  return recording;
}

/// In a map of the plan, from the true pose.
Result<Trajectory> localise(const Drive& drive, std::uint64_t seed, ScanLikelihood model) {
  const auto grid = sim::map_of_plan(drive.world->plan, drive.world->route_m.front());
  if (!grid) return grid.error();
  const auto map = LocalisationMap::make(*grid);
  if (!map) return map.error();
  const Eigen::Vector3d sigma(0.1, 0.1, 0.05);
  const Gaussian<SE2d> start{drive.recording.truth.front().T_map_base.raw(),
                             sigma.cwiseAbs2().asDiagonal()};
  LocalisationOptions options;
  options.model = model;
  const auto run = run_localisation(drive.recording, *map, options, seed, start);
  return run ? Result<Trajectory>(run->trajectory()) : run.error();
}

Result<Trajectory> particle_filter(const Drive& drive, std::uint64_t seed) {
  RadarSlamOptions options;
  options.seed = seed;
  return trajectory_of(run_radar_slam(drive.recording, options, SlamSensors::lidar));
}

}  // namespace

std::vector<System> scan_systems() {
  using eval::Alignment;
  return {
      {"graph", Alignment::rigid,
       [](const Drive& d, std::uint64_t) { return trajectory_of(run_graph_slam(d.recording)); }},
      {"submap", Alignment::rigid,
       [](const Drive& d, std::uint64_t) { return trajectory_of(run_submap_slam(d.recording)); }},
      {"submap, gyro", Alignment::rigid,
       [](const Drive& d, std::uint64_t) {
         return trajectory_of(run_submap_slam(without_odometry(d.recording, true)));
       }},
      {"Hector", Alignment::rigid,
       [](const Drive& d, std::uint64_t) { return trajectory_of(run_hector_slam(d.recording)); }},
      {"Hector, scans alone", Alignment::rigid,
       [](const Drive& d, std::uint64_t) {
         return trajectory_of(run_hector_slam(without_odometry(d.recording, false)));
       }},
      {"localisation, field", Alignment::none,
       [](const Drive& d, std::uint64_t seed) {
         return localise(d, seed, ScanLikelihood::likelihood_field);
       }},
      {"localisation, beams", Alignment::none,
       [](const Drive& d, std::uint64_t seed) { return localise(d, seed, ScanLikelihood::beam); }},
      {"particle filter", Alignment::rigid, particle_filter}};
}

}  // namespace wayfare::examples
