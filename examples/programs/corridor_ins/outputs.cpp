#include "outputs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include <wayfare/io/map_image.hpp>
#include <wayfare/io/report.hpp>
#include <wayfare/io/tum.hpp>
#include <wayfare/sensors/point_set.hpp>

namespace wayfare::examples {
namespace {

double degrees(double radians) { return Angle::radians(radians).degrees(); }

Trajectory trajectory_of(const CorridorRun& run) {
  Trajectory t;
  for (const CorridorEpoch& e : run.epochs)
    t.push_back({e.time, Transform2<frame::Map, frame::Base>(e.pose)});
  return t;
}

std::vector<eval::Evaluated> errors_of(const CorridorOutputs& o) {
  const Trajectory aided = trajectory_of(o.run), unaided = trajectory_of(o.unaided);
  return compare(o.truth, {{"with walls", aided}, {"without", unaided}});
}

const char* name_of(WallOutcome outcome) {
  constexpr std::array<const char*, 5> kNames = {"used", "none", "refused", "acquired", "skipped"};
  return kNames[static_cast<std::size_t>(outcome)];
}

std::string navigation_text(const CorridorOutputs& o) {
  std::string text =
      "# time x_m y_m heading_deg sigma_x_m sigma_y_m sigma_heading_deg bias_deg_s "
      "sigma_bias_deg_s speed_scale walls";
  text += o.plane ? " lat_deg lon_deg azimuth_deg\n" : "\n";
  for (const CorridorEpoch& e : o.run.epochs) {
    const Eigen::Vector3d sigma = e.pose_covariance.diagonal().cwiseSqrt();
    std::array<char, 400> line{};
    std::snprintf(line.data(), line.size(), "%.6f %.4f %.4f %.4f %.4f %.4f %.4f %.5f %.5f %.5f %s",
                  e.time.seconds(), e.pose.x(), e.pose.y(), e.pose.heading().degrees(), sigma[0],
                  sigma[1], degrees(sigma[2]), degrees(e.gyro_bias.value),
                  degrees(e.gyro_bias.sigma), e.speed_scale.value, name_of(e.update.outcome));
    text += line.data();
    if (o.plane) {
      const GeodeticHeading at = o.plane->geodetic(e.pose);
      std::snprintf(line.data(), line.size(), " %.9f %.9f %.4f", at.position.latitude.degrees(),
                    at.position.longitude.degrees(), at.azimuth.degrees());
      text += line.data();
    }
    text += '\n';
  }
  return text;
}

constexpr double kPanel_m = 20.0;

/// One scan around `middle`, ahead is up; side walls in green, the end wall in red.
void draw_scan(io::MapPainter& painter, const LaserScan& scan, const CorridorScanUpdate& update,
               const Eigen::Vector2d& middle) {
  const SE2d T(middle.x(), middle.y(), Angle::degrees(90));
  const auto inside = [&](const Eigen::Vector2d& p) { return p.cwiseAbs().maxCoeff() < 9.5; };
  const PointSet points = end_points(scan);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector2d p = points[i].cast<double>();
    if (inside(p)) painter.dot(T * p, io::kBlue, 3);
  }
  painter.dot(middle, io::kRed, 7);
  if (!update.walls) return;
  const SO2d rotation(update.walls->direction);
  for (const auto* wall : {&update.walls->left, &update.walls->right}) {
    if (!*wall) continue;
    const auto at = [&](double along) {
      return T * (rotation * Eigen::Vector2d(std::clamp(along, -9.0, 9.0), (*wall)->offset_m));
    };
    painter.path(std::array{at((*wall)->begin_m), at((*wall)->end_m)}, io::kGreen);
  }
  if (!update.walls->end || update.walls->end->rho_m > 9.0) return;
  const SO2d normal(update.walls->end->alpha);
  const double rho = update.walls->end->rho_m;
  painter.path(std::array{T * (normal * Eigen::Vector2d(rho, -1.0)),
                          T * (normal * Eigen::Vector2d(rho, 1.0))},
               io::kRed);
}

/// Eight scans, evenly distributed over the run.
io::Image walls_picture(const CorridorOutputs& o) {
  constexpr std::size_t kColumns = 4, kRows = 2;
  io::GridImage grid;
  grid.resolution_m = 0.05;
  const auto panel = static_cast<std::size_t>(kPanel_m / grid.resolution_m);
  grid.width = kColumns * panel;
  grid.height = kRows * panel;
  grid.occupancy.assign(grid.width * grid.height, 0.0F);
  io::MapPainter painter(grid);
  constexpr std::size_t kScans = kColumns * kRows;
  for (std::size_t i = 0; i < kScans; ++i) {
    const CorridorEpoch& e = o.run.epochs[(2 * i + 1) * o.run.epochs.size() / (2 * kScans)];
    const auto scan = std::lower_bound(o.recording.scans.begin(), o.recording.scans.end(), e.time,
                                       [](const LaserScan& s, LogTime t) { return s.time < t; });
    const std::size_t row = i / kColumns, column = i % kColumns;
    draw_scan(painter, *scan, e.update,
              {(double(column) + 0.5) * kPanel_m, (kRows - double(row) - 0.5) * kPanel_m});
  }
  return painter.picture();
}

io::Plot paths_plot(const CorridorOutputs& o, const std::vector<eval::Evaluated>& errors) {
  io::Plot plot = io::top_view("Paths");
  plot.series.push_back(io::path_series("with walls", trajectory_of(o.run)));
  plot.series.push_back(io::path_series("without", trajectory_of(o.unaided)));
  if (!errors.empty())
    plot.series.push_back(
        truth_series(o.truth, o.same_frame ? eval::Evaluation() : errors.front().errors));
  io::Series used{"walls used", {}, {}, io::Mark::points};
  for (std::size_t i = 0; i < o.run.epochs.size(); i += 5) {
    if (o.run.epochs[i].update.outcome != WallOutcome::used) continue;
    used.add(o.run.epochs[i].pose.x(), o.run.epochs[i].pose.y());
  }
  plot.series.push_back(std::move(used));
  return plot;
}

io::Plot bias_plot(const CorridorOutputs& o) {
  io::Plot plot = io::time_plot("Gyro bias", "deg/s");
  io::Series bias{"estimate", {}, {}}, low{"- 3 sigma", {}, {}, io::Mark::dashed},
      high{"+ 3 sigma", {}, {}, io::Mark::dashed}, truth{"truth", {}, {}};
  for (std::size_t i = 0; i < o.run.epochs.size(); ++i) {
    const CorridorEpoch& e = o.run.epochs[i];
    const double t = to_seconds(e.time - o.run.epochs.front().time);
    if (e.gyro_bias.sigma > 0.003) continue;  // the initial sigma is too large for the plot
    const double value = degrees(e.gyro_bias.value), sigma = degrees(e.gyro_bias.sigma);
    bias.add(t, value);
    low.add(t, value - 3 * sigma);
    high.add(t, value + 3 * sigma);
    if (i < o.bias.size()) truth.add(t, degrees(o.bias[i]));
  }
  plot.series = {std::move(bias), std::move(low), std::move(high)};
  if (!o.bias.empty()) plot.series.push_back(std::move(truth));
  return plot;
}

eval::Table events_table(const CorridorOutputs& o) {
  eval::Table table({{"event"}, {"time", "s"}});
  for (const auto& event : o.run.report.events)
    table.add_row({event.what, eval::fixed(to_seconds(event.time - o.run.epochs.front().time), 1)});
  return table;
}

io::Report report_of(const CorridorOutputs& o, const io::Image& walls) {
  io::Report report(o.title);
  report.doubt(o.doubt).facts(o.facts);
  for (const auto& [title, table] : tables_of(o)) report.heading(title).table(table);
  const std::vector<eval::Evaluated> errors = errors_of(o);
  report.heading("Path").plot(paths_plot(o, errors));
  for (const io::Plot& plot : distance_plots(o.truth, errors)) report.plot(plot);
  report.heading("Gyro bias").plot(bias_plot(o));
  report.heading("Walls in scans")
      .image(walls, "Eight scans, 20 m wide, ahead is up: side walls green, end wall red.");
  for (const io::Plot& plot : o.walls.empty() ? std::vector<io::Plot>() : plots_of(o.walls))
    report.plot(plot);
  if (!o.detectors.empty()) {
    report.heading("Tracking and curve fitting");
    for (const io::Plot& plot : detector_plots(o.detectors)) report.plot(plot);
  }
  if (!o.run.report.events.empty()) report.heading("Events").table(events_table(o));
  return report;
}

}  // namespace

TitledTables tables_of(const CorridorOutputs& o) {
  TitledTables tables = o.tables;
  const TitledTables errors = error_tables(o.truth, errors_of(o), o.same_frame);
  tables.insert(tables.end(), errors.begin(), errors.end());
  return tables;
}

Result<void> write_corridor_outputs(const OutputArguments& to, const CorridorOutputs& o) {
  const io::Image walls = walls_picture(o);
  return first_error(
      {io::write_file(to.path("navigation.txt"), navigation_text(o), to.write()),
       io::write_tum(to.path("trajectory.tum"), trajectory_of(o.run), to.write()),
       io::write_tum(to.path("unaided.tum"), trajectory_of(o.unaided), to.write()),
       io::write_png(to.path("walls.png"), walls, to.write()),
       o.walls.empty() ? Result<void>()
                       : io::write_file(to.path("walls.csv"), to_csv(o.walls), to.write()),
       o.detectors.empty()
           ? Result<void>()
           : io::write_file(to.path("detectors.txt"), detectors_text(o.detectors), to.write()),
       to.write_report(report_of(o, walls))});
}

}  // namespace wayfare::examples
