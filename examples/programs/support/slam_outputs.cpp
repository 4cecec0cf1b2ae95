#include "slam_outputs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>

#include <wayfare/io/g2o.hpp>
#include <wayfare/io/map_image.hpp>
#include <wayfare/io/report.hpp>
#include <wayfare/io/tum.hpp>
#include <wayfare/sensors/trajectory.hpp>

namespace wayfare::examples {
namespace {

namespace fs = std::filesystem;

// Odometry at the scans' times, with the first pose of SLAM's trajectory.
Trajectory odometry_at_scans(const SlamOutputs& run) {
  Trajectory result;
  const Trajectory odometry = as_trajectory(run.recording.odometry);
  if (odometry.empty()) return result;
  SE2d T_map_odom;
  for (const StampedPose& pose : run.trajectory) {
    const LogTime time = std::clamp(pose.time, odometry.front().time, odometry.back().time);
    const SE2d T_odom_base = *pose_at(odometry, time);
    if (result.empty()) T_map_odom = pose.T_map_base.raw() * T_odom_base.inverse();
    result.push_back({pose.time, Transform2<frame::Map, frame::Base>(T_map_odom * T_odom_base)});
  }
  return result;
}

NamedErrors errors_of(std::string name, const Trajectory& estimate, const Trajectory& reference) {
  NamedErrors result{std::move(name), eval::absolute_error(estimate, reference)};
  const std::vector<eval::PosePair> pairs = eval::associate(estimate, reference);
  if (pairs.empty()) return result;
  const auto motion = [&](const SE2d eval::PosePair::*pose) {
    return (pairs.front().*pose).inverse() * (pairs.back().*pose);
  };
  const SE2d error =
      motion(&eval::PosePair::reference).inverse() * motion(&eval::PosePair::estimate);
  result.final_error_m = error.translation().norm();
  result.final_percent = 100.0 * result.final_error_m / result.absolute.path_length_m;
  return result;
}

io::Plot paths_plot(const SlamOutputs& run, const std::vector<NamedErrors>& errors) {
  io::Plot plot = io::top_view("Trajectories");
  plot.series.push_back(io::path_series("SLAM", run.trajectory));
  const Trajectory odometry = odometry_at_scans(run);
  if (!odometry.empty()) plot.series.push_back(io::path_series("odometry", odometry));
  for (const NamedTrajectory& other : run.others)
    plot.series.push_back(io::path_series(other.name, other.trajectory));
  if (!errors.empty()) {
    const SE2d T_map_reference = errors.back().absolute.alignment.inverse();
    plot.series.push_back(
        io::path_series("reference", *run.reference, T_map_reference, io::Mark::dashed));
  }
  return plot;
}

io::Plot error_plot(const SlamOutputs& run, const std::vector<NamedErrors>& errors) {
  io::Plot plot = io::time_plot("Distance from the reference after rigid alignment", "error [m]");
  for (auto e = errors.rbegin(); e != errors.rend(); ++e) {  // SLAM first, as in the other plots
    io::Series series{e->name, {}, e->absolute.translations_m};
    for (const LogTime time : e->absolute.times)
      series.x.push_back(to_seconds(time - run.trajectory.front().time));
    plot.series.push_back(std::move(series));
  }
  return plot;
}

io::Plot graph_plot(const PoseGraph2& graph) {
  io::Plot plot = io::top_view("Pose graph");
  io::Series chain{"edges between neighbours", {}, {}}, loops{"loop closures", {}, {}};
  constexpr double kBreak = std::numeric_limits<double>::quiet_NaN();
  for (const PoseEdge<SE2d>& edge : graph.edges) {
    io::Series& series = edge.robust ? loops : chain;
    for (const int i : {edge.from, edge.to}) {
      const SE2d& pose = graph.poses[static_cast<std::size_t>(i)];
      series.add(pose.x(), pose.y());
    }
    series.add(kBreak, kBreak);
  }
  plot.series = {std::move(chain), std::move(loops)};
  return plot;
}

io::Report report_of(const SlamOutputs& run, const io::GridImage& grid) {
  const std::vector<NamedErrors> errors = trajectory_errors(run);
  io::Report report(run.title);
  report.facts(run.facts);
  if (!errors.empty()) report.heading("Errors against the reference").table(error_table(errors));
  for (const auto& [title, table] : run.tables) report.heading(title).table(table);
  report.heading("Map").image(
      io::MapPainter(grid).path(points_of(run.trajectory), io::kBlue).picture(),
      "The map and the robot's path.");
  report.heading("Trajectories").plot(paths_plot(run, errors));
  if (!errors.empty()) report.plot(error_plot(run, errors));
  if (!run.graph.poses.empty()) report.heading("Pose graph").plot(graph_plot(run.graph));
  return report;
}

constexpr std::array kNames = {"trajectory.tum", "map.pgm",   "map.yaml",
                               "map.png",        "graph.g2o", "report.html"};

}  // namespace

Result<void> prepare_folder(const std::string& folder, const io::WriteOptions& options,
                            const std::vector<std::string>& more) {
  std::vector<std::string> names(kNames.begin(), kNames.end());
  names.insert(names.end(), more.begin(), more.end());
  return prepare_files(folder, names, options);
}

std::vector<Eigen::Vector2d> points_of(const Trajectory& trajectory) {
  std::vector<Eigen::Vector2d> points;
  points.reserve(trajectory.size());
  for (const StampedPose& pose : trajectory) points.push_back(pose.T_map_base.raw().translation());
  return points;
}

std::vector<NamedErrors> trajectory_errors(const SlamOutputs& run) {
  if (run.reference == nullptr) return {};
  std::vector<NamedErrors> errors;
  const Trajectory odometry = odometry_at_scans(run);
  if (!odometry.empty()) errors.push_back(errors_of("odometry", odometry, *run.reference));
  for (const NamedTrajectory& other : run.others)
    errors.push_back(errors_of(other.name, other.trajectory, *run.reference));
  errors.push_back(errors_of("SLAM", run.trajectory, *run.reference));
  return errors;
}

eval::Table path_table(const SlamOutputs& run) {
  eval::Table table({{"path"}, {"length", "m"}, {"end from start", "m"}});
  const auto row = [&](const std::string& name, const Trajectory& path) {
    const auto points = points_of(path);
    const double end_m = points.empty() ? 0.0 : (points.back() - points.front()).norm();
    table.add_row({name, eval::fixed(eval::path_length_m(path), 2), eval::fixed(end_m, 2)});
  };
  for (const NamedTrajectory& other : run.others) row(other.name, other.trajectory);
  row("SLAM", run.trajectory);
  return table;
}

eval::Table error_table(const std::vector<NamedErrors>& errors) {
  eval::Table table({{""},
                     {"ATE RMSE", "m"},
                     {"heading RMSE", "deg"},
                     {"largest", "m"},
                     {"at the end", "m"},
                     {"of the path", "%"}});
  for (const NamedErrors& e : errors) {
    table.add_row({e.name, eval::fixed(e.absolute.translation_m.rmse, 3),
                   eval::fixed(e.absolute.rmse_heading_deg, 2),
                   eval::fixed(e.absolute.translation_m.max, 3), eval::fixed(e.final_error_m, 3),
                   eval::fixed(e.final_percent, 2)});
  }
  return table;
}

io::Image map_picture(const OccupancyGrid& map, const Trajectory& trajectory) {
  return io::MapPainter(io::grid_image(map)).path(points_of(trajectory), io::kBlue).picture();
}

Result<std::string> write_slam_outputs(const std::string& folder_name, const SlamOutputs& run,
                                       const io::WriteOptions& options) {
  const fs::path folder(folder_name);
  std::vector<std::string> others;
  for (const NamedTrajectory& other : run.others) others.push_back(other.file);
  if (auto ready = prepare_folder(folder_name, options, others); !ready) return ready.error();
  const auto path = [&](const char* name) { return (folder / name).string(); };
  const io::GridImage grid = io::grid_image(run.map);

  io::MapImageOptions map_options;
  map_options.file = options;
  io::MapImageOptions radar_options = map_options;
  // One detection is likely clutter, three in one cell are an object.
  radar_options.occupied_threshold = 0.9;
  const auto done = first_error(
      {io::write_tum(path("trajectory.tum"), run.trajectory, options),
       io::write_map(path("map"), grid, map_options),
       run.radar_map
           ? io::write_map(path("radar_map"), io::grid_image(*run.radar_map), radar_options)
           : Result<void>(),
       io::write_png(path("map.png"), io::to_picture(grid), options),
       run.graph.poses.empty() ? Result<void>()
                               : io::write_g2o(path("graph.g2o"), io::to_file(run.graph), options),
       report_of(run, grid).write(path("report.html"), options)});
  if (!done) return done.error();
  for (const NamedTrajectory& other : run.others)
    if (auto ok = io::write_tum(path(other.file.c_str()), other.trajectory, options); !ok)
      return ok.error();
  return path("report.html");
}

}  // namespace wayfare::examples
