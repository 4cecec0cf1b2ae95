#include "methods.hpp"

#include <utility>

#include <wayfare/nav/corridor_ins.hpp>
#include <wayfare/pedestrian/pedestrian.hpp>
#include <wayfare/sensors/trajectory.hpp>
#include <wayfare/slam/graph_slam.hpp>
#include <wayfare/slam/hector_slam.hpp>
#include <wayfare/slam/pedestrian_slam.hpp>
#include <wayfare/slam/radar_slam.hpp>
#include <wayfare/slam/submap_slam.hpp>

#include "corridor_ins/on_log.hpp"

namespace wayfare::examples {
namespace {

std::string lacks_odometry(const MethodData& d) {
  return d.recording.odometry.empty() ? "the log has no odometry" : "";
}
std::string lacks_scans(const MethodData& d) {
  return d.recording.scans.empty() ? "the log has no laser scans" : "";
}
std::string lacks_radar(const MethodData& d) {
  return d.recording.radar.empty() ? "the log has no radar frames" : "";
}
std::string lacks_unit(const MethodData& d) {
  return d.unit ? "" : "the log has no inertial unit, and --unit names none";
}
std::string lacks_scans_or_motion(const MethodData& d) {
  std::string scans = lacks_scans(d);
  if (!scans.empty() || !motion_of(d.recording).empty()) return scans;
  return "the log has neither gyro and wheels nor odometry";
}
std::string lacks_both(const MethodData& d) {
  const std::string scans = lacks_scans(d);
  return scans.empty() ? lacks_radar(d) : scans;
}
std::string lacks_scans_or_unit(const MethodData& d) {
  const std::string scans = lacks_scans(d);
  return scans.empty() ? lacks_unit(d) : scans;
}

/// The trajectory of a system's run.
template <class Run>
Result<Trajectory> trajectory_of(Result<Run> run) {
  if (!run) return run.error();
  return std::move(run->trajectory);
}

Result<Trajectory> odometry(const MethodData& d, const SlamProgress&) {
  return as_trajectory(d.recording.odometry);
}

Result<Trajectory> pedestrian(const MethodData& d, const SlamProgress& progress) {
  PedestrianParameters p;
  p.forward = d.mounting.forward_axis(*d.unit, d.recording);
  p.ahrs.use_magnetometer = d.unit->file.has_magnetometer;
  Pedestrian walker(p);
  Trajectory steps;
  const MargRecording& samples = d.unit->file.samples;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    walker.add(samples[i], [&](const PedestrianPose& step) {
      steps.push_back({step.time, Transform2<frame::Map, frame::Base>(SE2d(
                                      step.position_m.x(), step.position_m.y(), step.heading))});
    });
    if (i % 4096 == 0 && progress)
      progress(static_cast<double>(i) / static_cast<double>(samples.size()));
  }
  if (steps.empty()) return Error{ErrorCode::degenerate, "no steps were found"};
  return steps;
}

Result<Trajectory> hector(const MethodData& d, const SlamProgress& progress) {
  HectorSlamOptions options;
  if (!d.unit) return trajectory_of(run_hector_slam(d.recording, options, progress));
  options.q_base_unit = d.mounting.q_base_unit(*d.unit, d.recording);
  return trajectory_of(run_hector_slam(d.recording, d.unit->file.samples, options, progress));
}

Result<Trajectory> submaps(const MethodData& d, const SlamProgress& progress) {
  SubmapSlamOptions options;
  options.threads = d.threads;
  return trajectory_of(run_submap_slam(d.recording, options, progress));
}

Result<Trajectory> pedestrian_submaps(const MethodData& d, const SlamProgress& progress) {
  PedestrianSlamOptions options;
  options.q_unit_laser = d.mounting.q_unit_laser(*d.unit, d.recording);
  options.pedestrian.forward = d.mounting.forward_axis(*d.unit, d.recording);
  options.pedestrian.ahrs.use_magnetometer = d.unit->file.has_magnetometer;
  options.slam.threads = d.threads;
  auto walk = run_pedestrian_slam(d.recording, d.unit->file.samples, options, progress);
  if (!walk) return walk.error();
  return std::move(walk->slam.trajectory);
}

Result<Trajectory> graph(const MethodData& d, const SlamProgress& progress) {
  GraphSlamOptions options;
  options.threads = d.threads;
  return trajectory_of(run_graph_slam(d.recording, options, progress));
}

/// With as many passes as in corridor_ins, and its direction of travel.
Result<Trajectory> corridor(const MethodData& d, const SlamProgress& progress) {
  constexpr int kPasses = 4;
  const auto run =
      run_corridor_passes(d.recording, signed_motion_of(d.recording).motion,
                          corridor_options_of(d.recording), kPasses, [&](double fraction) {
                            if (progress) progress(fraction);
                          });
  if (!run) return run.error();
  Trajectory trajectory;
  for (const CorridorEpoch& epoch : run->epochs)
    trajectory.push_back({epoch.time, Transform2<frame::Map, frame::Base>(epoch.pose)});
  return trajectory;
}

/// With as many particles as in radar_slam.
auto particles(SlamSensors sensors) {
  return [sensors](const MethodData& d, const SlamProgress& progress) {
    RadarSlamOptions options;
    options.threads = d.threads;
    options.seed = d.seed;
    options.particles = particles_of(sensors);
    return trajectory_of(run_radar_slam(d.recording, options, sensors, progress));
  };
}

}  // namespace

const std::vector<Method>& methods() {
  static const std::vector<Method> all = {
      {"odometry", "odometry", "odometry", lacks_odometry, odometry},
      {"corridor", "corridor filter", "scans and gyro with wheels, or odometry",
       lacks_scans_or_motion, corridor},
      {"pdr", "dead reckoning by steps", "inertial unit", lacks_unit, pedestrian},
      {"hector", "Hector SLAM", "scans, with odometry and unit if any", lacks_scans, hector},
      {"submap", "submap SLAM", "scans, with odometry if any", lacks_scans, submaps},
      {"pedestrian", "pedestrian SLAM", "scans and unit", lacks_scans_or_unit, pedestrian_submaps},
      {"graph", "graph SLAM", "scans, with odometry if any", lacks_scans, graph},
      {"lidar", "particle filter, LiDAR", "scans and odometry or wheels", lacks_scans,
       particles(SlamSensors::lidar)},
      {"radar", "particle filter, radar", "radar and odometry or wheels", lacks_radar,
       particles(SlamSensors::radar)},
      {"radar_lidar", "particle filter, radar and LiDAR", "both and odometry or wheels", lacks_both,
       particles(SlamSensors::both)}};
  return all;
}

}  // namespace wayfare::examples
