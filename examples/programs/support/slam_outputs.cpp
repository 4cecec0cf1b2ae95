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

io::Plot paths_plot(const SlamOutputs& run, const std::vector<eval::Evaluated>& errors) {
  io::Plot plot = io::top_view("Trajectories");
  plot.series.push_back(io::path_series("SLAM", run.trajectory));
  const Trajectory odometry = odometry_at_scans(run);
  if (!odometry.empty()) plot.series.push_back(io::path_series("odometry", odometry));
  for (const OtherEstimate& other : run.others)
    plot.series.push_back(io::path_series(other.name, other.trajectory));
  if (!errors.empty()) plot.series.push_back(truth_series(run.truth, errors.back().errors));
  return plot;
}

/// Lengths and ends of SLAM's path and of others.
eval::Table path_table(const SlamOutputs& run) {
  eval::Table table({{"path"}, {"length", "m"}, {"end from start", "m"}});
  const auto row = [&](const std::string& name, const Trajectory& path) {
    const auto points = points_of(path);
    const double end_m = points.empty() ? 0.0 : (points.back() - points.front()).norm();
    table.add_row({name, eval::fixed(eval::path_length_m(path), 2), eval::fixed(end_m, 2)});
  };
  for (const OtherEstimate& other : run.others) row(other.name, other.trajectory);
  row("SLAM", run.trajectory);
  return table;
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
  std::vector<eval::Evaluated> errors = trajectory_errors(run);
  io::Report report(run.title);
  report.facts(run.facts);
  for (const auto& [title, table] : tables_of(run)) report.heading(title).table(table);
  io::MapPainter painter(grid);
  if (!errors.empty()) draw_truth(painter, run.truth, errors.back().errors);
  report.heading("Map").image(painter.path(points_of(run.trajectory), io::kBlue).picture(),
                              errors.empty()
                                  ? "The map and the robot's path."
                                  : "The map, the robot's path and, in green, the true path.");
  report.heading("Trajectories").plot(paths_plot(run, errors));
  std::reverse(errors.begin(), errors.end());  // SLAM first, as in the other plots
  for (const io::Plot& plot : distance_plots(run.truth, errors)) report.plot(plot);
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

std::vector<eval::Evaluated> trajectory_errors(const SlamOutputs& run) {
  const Trajectory odometry = odometry_at_scans(run);
  std::vector<NamedTrajectory> all;
  if (!odometry.empty()) all.push_back({"odometry", odometry});
  for (const OtherEstimate& other : run.others) all.push_back({other.name, other.trajectory});
  all.push_back({"SLAM", run.trajectory});
  return compare(run.truth, all);
}

TitledTables tables_of(const SlamOutputs& run) {
  TitledTables tables = error_tables(run.truth, trajectory_errors(run));
  if (!run.others.empty()) tables.emplace_back("Paths", path_table(run));
  tables.insert(tables.end(), run.tables.begin(), run.tables.end());
  return tables;
}

io::Image map_picture(const OccupancyGrid& map, const Trajectory& trajectory) {
  return io::MapPainter(io::grid_image(map)).path(points_of(trajectory), io::kBlue).picture();
}

Result<std::string> write_slam_outputs(const std::string& folder_name, const SlamOutputs& run,
                                       const io::WriteOptions& options, const std::string& json) {
  const fs::path folder(folder_name);
  const OutputArguments to{folder_name, json, options.existing == io::Existing::replace};
  std::vector<std::string> others;
  for (const OtherEstimate& other : run.others) others.push_back(other.file);
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
       to.write_report(report_of(run, grid))});
  if (!done) return done.error();
  for (const OtherEstimate& other : run.others)
    if (auto ok = io::write_tum(path(other.file.c_str()), other.trajectory, options); !ok)
      return ok.error();
  return path("report.html");
}

}  // namespace wayfare::examples
