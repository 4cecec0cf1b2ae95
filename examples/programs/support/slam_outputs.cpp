#include "slam_outputs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>

#include <wayfare/io/g2o.hpp>
#include <wayfare/io/map_image.hpp>
#include <wayfare/io/report.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/io/tum.hpp>
#include <wayfare/sensors/trajectory.hpp>

#include "scan_points.hpp"

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

/// Those of all particles below the others, on the map.
io::Plot particles_plot(const SlamOutputs& run, const std::vector<eval::Evaluated>& errors) {
  io::Plot plot = paths_plot(run, errors);
  plot.title = "Paths of all particles";
  constexpr double kBreak = std::numeric_limits<double>::quiet_NaN();
  io::Series all{"particles", {}, {}};
  for (const Trajectory& path : run.particle_paths) {
    for (const Eigen::Vector2d& p : points_of(path)) all.add(p.x(), p.y());
    all.add(kBreak, kBreak);
  }
  plot.series.insert(plot.series.begin(), std::move(all));
  plot.image = io::plot_image(io::grid_image(run.map));
  return plot;
}

/// LiDAR and radar points along the path, on the map.
io::Plot scans_plot(const SlamOutputs& run) {
  const io::GridImage grid = io::grid_image(run.map);
  const ScanPoints points = place_scans(run.recording, run.trajectory, {});
  io::Plot plot = io::top_view("Scans along the path");
  const double spacing_m =
      grid.resolution_m * static_cast<double>(std::max(grid.width, grid.height)) / 1000.0;
  plot.series = {points_series("radar", points.radar_m, spacing_m),
                 points_series("LiDAR", points.lidar_m, spacing_m),
                 io::path_series("SLAM", run.trajectory)};
  plot.image = io::plot_image(grid);
  return plot;
}

std::string particles_text(const std::vector<Trajectory>& paths) {
  std::string text = "particle,time_s,x_m,y_m,heading_deg\n";
  for (std::size_t i = 0; i < paths.size(); ++i) {
    for (const StampedPose& p : paths[i]) {
      const SE2d& pose = p.T_map_base.raw();
      text += std::to_string(i + 1) + ',' + eval::fixed(p.time.seconds(), 6) + ',' +
              eval::fixed(pose.x(), 4) + ',' + eval::fixed(pose.y(), 4) + ',' +
              eval::fixed(pose.heading().degrees(), 4) + '\n';
    }
  }
  return text;
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

io::Report report_of(const SlamOutputs& run) {
  std::vector<eval::Evaluated> errors = trajectory_errors(run);
  io::Report report(run.title);
  report.doubt(run.doubt).facts(run.facts);
  for (const auto& [title, table] : tables_of(run)) report.heading(title).table(table);
  io::MapPainter painter(run.map);
  if (!errors.empty()) draw_truth(painter, run.truth, errors.back().errors);
  report.heading("Map").image(painter.path(points_of(run.trajectory), io::kBlue).rows(),
                              errors.empty()
                                  ? "The map and the robot's path."
                                  : "The map, the robot's path and, in green, the true path.");
  report.heading("Trajectories").plot(paths_plot(run, errors));
  if (!run.particle_paths.empty()) report.plot(particles_plot(run, errors));
  if (run.draw_scans) report.plot(scans_plot(run));
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

std::vector<std::string> picture_files(bool particle_paths, bool scans) {
  std::vector<std::string> files;
  if (particle_paths) files.insert(files.end(), {"particles.csv", "particles.svg"});
  if (scans) files.emplace_back("scans.svg");
  return files;
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
  return io::MapPainter(map).path(points_of(trajectory), io::kBlue).picture();
}

Result<std::string> write_slam_outputs(const std::string& folder_name, const SlamOutputs& run,
                                       const io::WriteOptions& options, const std::string& json) {
  const fs::path folder(folder_name);
  const OutputArguments to{folder_name, json, options.existing == io::Existing::replace};
  std::vector<std::string> others = picture_files(!run.particle_paths.empty(), run.draw_scans);
  for (const OtherEstimate& other : run.others) others.push_back(other.file);
  if (auto ready = prepare_folder(folder_name, options, others); !ready) return ready.error();
  const auto path = [&](const char* name) { return (folder / name).string(); };

  io::MapImageOptions map_options;
  map_options.file = options;
  io::MapImageOptions radar_options = map_options;
  // One detection is likely clutter, three in one cell are an object.
  radar_options.occupied_threshold = 0.9;
  const auto done = first_error(
      {io::write_tum(path("trajectory.tum"), run.trajectory, options),
       io::write_map(path("map"), run.map, map_options),
       run.radar_map ? io::write_map(path("radar_map"), *run.radar_map, radar_options)
                     : Result<void>(),
       io::write_png(path("map.png"), io::picture_rows(run.map), options),
       run.graph.poses.empty() ? Result<void>()
                               : io::write_g2o(path("graph.g2o"), io::to_file(run.graph), options),
       to.write_report(report_of(run))});
  if (!done) return done.error();
  const auto write = [&](const char* name, const std::string& text) {
    return io::write_file(path(name), text, options);
  };
  if (!run.particle_paths.empty()) {
    const io::Plot plot = particles_plot(run, trajectory_errors(run));
    const auto drawn = first_error({write("particles.csv", particles_text(run.particle_paths)),
                                    write("particles.svg", io::to_svg_document(plot))});
    if (!drawn) return drawn.error();
  }
  if (run.draw_scans)
    if (auto ok = write("scans.svg", io::to_svg_document(scans_plot(run))); !ok) return ok.error();
  for (const OtherEstimate& other : run.others)
    if (auto ok = io::write_tum(path(other.file.c_str()), other.trajectory, options); !ok)
      return ok.error();
  return path("report.html");
}

}  // namespace wayfare::examples
