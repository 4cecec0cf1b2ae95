#include "trials.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <limits>

#include <wayfare/eval/trajectory_error.hpp>
#include <wayfare/io/map_image.hpp>
#include <wayfare/sensors/trajectory.hpp>
#include <wayfare/sim/floor_plan.hpp>
#include <wayfare/sim/simulate_recording.hpp>
#include <wayfare/sim/worlds.hpp>
#include <wayfare/slam/radar_slam.hpp>

namespace wayfare::examples {
namespace {

struct Scene {
  sim::World world;
  sim::WorldRobot robot;
};

Result<sim::World> world_of(const std::string& name, const Rng& rng) {
  const std::size_t comma = name.find(',');
  if (comma == std::string::npos) return sim::make_world(name, rng);
  const auto voxels = io::read_points(name.substr(0, comma));
  if (!voxels) return voxels.error();
  const auto path = io::read_points(name.substr(comma + 1));
  if (!path) return path.error();
  return sim::world_of_voxels(voxels->points_m, path->points_m, {}, rng);
}

Result<Scene> scene_of(const CourseOptions& options) {
  const Rng rng(options.seed);
  if (options.world == "building") {
    auto planned = sim::read_plan(sim::demo_building());
    if (!planned) return planned.error();
    sim::WorldRobot robot;
    robot.robot.wheels.right_scale = 1.001;
    robot.robot.T_base_laser = Transform2<frame::Base, frame::Laser>(SE2d(0.15, 0.0, Angle{}));
    return Scene{sim::furnished_world(std::move(planned->plan), std::move(planned->route_m), {}, {},
                                      rng.stream(1)),
                 robot};
  }
  auto world = world_of(options.world, rng.stream(1));
  if (!world) return world.error();
  return Scene{std::move(*world), sim::turtlebot(rng.stream(2))};
}

/// Radar detections from the known poses of another robot on the same path.
Result<OccupancyGrid> survey(const Scene& scene, double cell_m, const Rng& rng) {
  auto robot = scene.robot;
  robot.robot.lidar = sim::full_circle(8);  // not used
  const auto recording = sim::simulate_world(scene.world, robot, rng);
  if (!recording) return recording.error();
  OccupancyGrid grid({.resolution_m = cell_m});
  const LogOdds hit = LogOdds::from_probability(RadarSlamOptions{}.radar_hit_probability);
  for (const RadarScan& frame : recording->radar) {
    const auto pose = pose_at(recording->truth, frame.time);
    if (!pose) continue;
    const SE2d T_map_radar = *pose * recording->T_base_radar.raw();
    for (const RadarPoint& p : frame.points)
      grid.update(cell_of(T_map_radar * Eigen::Vector2d(p.x_m, p.y_m), cell_m), hit);
  }
  return grid;
}

Result<Recording> drive(const Scene& scene, bool with_radar, const Rng& rng) {
  if (with_radar) return sim::simulate_world(scene.world, scene.robot, rng);
  auto run = sim::simulate_recording(scene.world.plan, scene.world.route_m, scene.robot.robot, rng);
  if (!run) return run.error();
  run->recording.truth = std::move(run->truth);
  return std::move(run->recording);
}

/// Distance travelled up to each pose of the truth, m.
std::vector<double> distances(const Trajectory& truth) {
  std::vector<double> distance{0.0};
  for (std::size_t i = 1; i < truth.size(); ++i)
    distance.push_back(distance.back() + (truth[i].T_map_base.raw().translation() -
                                          truth[i - 1].T_map_base.raw().translation())
                                             .norm());
  return distance;
}

LogTime time_at(const Trajectory& truth, const std::vector<double>& distance, double metres) {
  const auto at = std::lower_bound(distance.begin(), distance.end(), metres) - distance.begin();
  return truth[std::min(static_cast<std::size_t>(at), truth.size() - 1)].time;
}

/// Result of the search that began at `from`, over `longest_m`.
Search judge(const LocalisationRun& run, const Course& course, const Trajectory& truth,
             LogTime from, double longest_m) {
  const std::vector<double> distance = distances(truth);
  const auto distance_at = [&](LogTime time) {
    const auto at = std::lower_bound(truth.begin(), truth.end(), time,
                                     [](const StampedPose& p, LogTime t) { return p.time < t; });
    return distance[std::min(static_cast<std::size_t>(at - truth.begin()), truth.size() - 1)];
  };
  const double start = distance_at(from);
  Search search;
  search.distance_m = std::numeric_limits<double>::quiet_NaN();
  double scans = 0.0, wrong = 0.0;
  for (const LocalisationOutcome& o : run.outcomes) {
    const auto pose = pose_at(truth, o.time);
    const double travelled = distance_at(o.time) - start;
    if (o.time < from || !pose || travelled > longest_m) continue;
    const bool correct = o.converged && pose_error(o.T_map_base.mean, *pose).correct();
    if (correct && !search.found) search.distance_m = travelled;
    search.found = correct;
    const bool mirrored =
        course.symmetry && pose_error(o.T_map_base.mean, *course.symmetry * *pose).correct();
    search.best_is_correct = mirrored || pose_error(o.T_map_base.mean, *pose).correct();
    search.wrong = o.converged && !correct;
    scans += 1.0;
    wrong += search.wrong ? 1.0 : 0.0;
    search.mirrored = search.wrong && mirrored;
    search.clusters = o.clusters;
  }
  search.share_wrong = scans > 0.0 ? wrong / scans : 0.0;
  if (!search.found) search.distance_m = std::numeric_limits<double>::quiet_NaN();
  return search;
}

Gaussian<SE2d> known(const SE2d& pose) {
  Gaussian<SE2d> start{pose, Eigen::Matrix3d::Zero()};
  start.covariance.diagonal() << 0.01, 0.01, 0.0025;
  return start;
}

}  // namespace

PoseError pose_error(const SE2d& estimate, const SE2d& truth) {
  const double heading = estimate.heading().radians() - truth.heading().radians();
  return {(estimate.translation() - truth.translation()).norm(),
          std::abs(Angle::radians(wrap_to_pi(heading)).degrees())};
}

Result<Course> make_course(const CourseOptions& options) {
  auto scene = scene_of(options);
  if (!scene) return scene.error();
  const Rng rng(options.seed);
  auto recording = drive(*scene, options.radar, rng.stream(3));
  if (!recording) return recording.error();
  const auto grid = sim::map_of_plan(scene->world.plan, scene->world.route_m.front(),
                                     {.resolution_m = options.cell_m});
  if (!grid) return grid.error();
  std::optional<OccupancyGrid> seen;
  if (options.radar) {
    auto surveyed = survey(*scene, options.cell_m, rng.stream(6));
    if (!surveyed) return surveyed.error();
    seen = *std::move(surveyed);
  }
  auto map = LocalisationMap::make(*grid, options.map, seen ? &*seen : nullptr);
  if (!map) return map.error();
  const std::string file = options.world.substr(0, options.world.find(','));
  Course course{std::filesystem::path(file).filename().string(), *std::move(recording), *map};
  // Rotation by 180 degrees about the centre of its 18 m x 30 m.
  if (options.world == "corridor_loop") course.symmetry = SE2d(18.0, 30.0, 180.0_deg);
  return course;
}

Result<Search> try_global(const Course& course, const LocalisationOptions& options,
                          std::uint64_t seed, double distance_m) {
  const Trajectory& truth = course.recording.truth;
  const std::vector<double> distance = distances(truth);
  Rng rng = Rng(seed).stream(4);
  const double from = rng.uniform() * std::max(0.0, distance.back() - distance_m - 1.0);
  const LogTime begin = time_at(truth, distance, from);
  const Recording part =
      sim::part_of(course.recording, begin, time_at(truth, distance, from + distance_m + 1.0));
  const auto run = run_localisation(part, course.map, options, seed);
  if (!run) return run.error();
  return judge(*run, course, part.truth, begin, distance_m);
}

Result<Search> try_kidnapped(const Course& course, const LocalisationOptions& options,
                             std::uint64_t seed, double distance_m) {
  const Trajectory& truth = course.recording.truth;
  const std::vector<double> distance = distances(truth);
  Rng rng = Rng(seed).stream(5);
  constexpr double kBefore_m = 5.0;
  const LogTime lifted = time_at(truth, distance, kBefore_m);
  const SE2d there = *pose_at(truth, lifted);
  // At a pose that differs enough from the last one.
  LogTime down = lifted;
  for (int tries = 0; tries < 100; ++tries) {
    const double at =
        rng.uniform(kBefore_m, std::max(kBefore_m, distance.back() - distance_m - 1.0));
    down = time_at(truth, distance, at);
    const PoseError apart = pose_error(*pose_at(truth, down), there);
    if (apart.m > 2.0 || apart.deg > 60.0) break;
  }
  const Recording carried = sim::kidnapped(course.recording, lifted, down);
  const std::vector<double> carried_distance = distances(carried.truth);
  const double jump = (pose_at(truth, down)->translation() - there.translation()).norm();
  const Recording part =
      sim::part_of(carried, carried.truth.front().time,
                   time_at(carried.truth, carried_distance, kBefore_m + jump + distance_m + 1.0));
  const auto run =
      run_localisation(part, course.map, options, seed, known(part.truth.front().T_map_base.raw()));
  if (!run) return run.error();
  return judge(*run, course, part.truth, lifted, distance_m);
}

Result<Tracking> try_tracking(const Course& course, const LocalisationOptions& options,
                              std::uint64_t seed) {
  const auto started = std::chrono::steady_clock::now();
  const auto run = run_localisation(course.recording, course.map, options, seed,
                                    known(course.recording.truth.front().T_map_base.raw()));
  if (!run) return run.error();
  const std::chrono::duration<double, std::nano> took = std::chrono::steady_clock::now() - started;
  Tracking result;
  double square_m = 0.0, square_deg = 0.0, weighed = 0.0;
  const auto n = static_cast<double>(run->outcomes.size());
  for (const LocalisationOutcome& o : run->outcomes) {
    const auto truth = pose_at(course.recording.truth, o.time);
    if (!truth) continue;
    const PoseError e = pose_error(o.T_map_base.mean, *truth);
    square_m += e.m * e.m / n;
    square_deg += e.deg * e.deg / n;
    result.worst_m = std::max(result.worst_m, e.m);
    result.converged += o.converged ? 1.0 / n : 0.0;
    result.particles += static_cast<double>(o.particles) / n;
    weighed += o.weighed ? static_cast<double>(o.particles) : 0.0;
  }
  result.rmse_m = std::sqrt(square_m);
  result.rmse_deg = std::sqrt(square_deg);
  result.ns_per_beam = took.count() / (weighed * options.beams);
  return result;
}

}  // namespace wayfare::examples
