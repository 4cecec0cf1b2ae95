#include "outputs.hpp"

#include <cmath>
#include <limits>
#include <optional>

#include <wayfare/core/statistics.hpp>
#include <wayfare/io/map_image.hpp>
#include <wayfare/io/report.hpp>
#include <wayfare/io/tum.hpp>
#include <wayfare/sensors/trajectory.hpp>

#include "support/slam_outputs.hpp"
#include "trials.hpp"

namespace wayfare::examples {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

struct ErrorList {
  std::vector<double> m, deg;

  void add(const PoseError& error) {
    m.push_back(error.m);
    deg.push_back(error.deg);
  }
};

struct Errors {
  std::vector<double> seconds;
  ErrorList each;  // of every scan; NaN without truth or particles
  ErrorList converged, all;
};

Errors errors_of(const LocalisationOutputs& o) {
  Errors e;
  const LogTime start = o.run.outcomes.front().time;
  for (const LocalisationOutcome& outcome : o.run.outcomes) {
    e.seconds.push_back(to_seconds(outcome.time - start));
    const auto truth = pose_at(o.truth.poses, outcome.time);
    const bool known = truth && outcome.particles > 0;
    const PoseError error =
        known ? pose_error(outcome.T_map_base.mean, *truth) : PoseError{kNan, kNan};
    e.each.add(error);
    if (known) e.all.add(error);
    if (known && outcome.converged) e.converged.add(error);
  }
  return e;
}

std::string table_of_poses(const LocalisationOutputs& o) {
  std::string text =
      "t_s,x_m,y_m,heading_rad,sigma_x_m,sigma_y_m,sigma_heading_rad,believed,mass,places,"
      "particles,agreement,weighed,searched,moved,odometry_refused,error_m,error_deg,sensor\n";
  const Errors errors = errors_of(o);
  for (std::size_t i = 0; i < o.run.outcomes.size(); ++i) {
    const LocalisationOutcome& s = o.run.outcomes[i];
    const SE2d& pose = s.T_map_base.mean;
    const Eigen::Vector3d sigma = s.T_map_base.covariance.diagonal().cwiseSqrt();
    const auto number = [](double value) { return eval::fixed(value, 5) + ","; };
    const auto flag = [](bool value) { return std::string(value ? "1," : "0,"); };
    text += eval::fixed(s.time.seconds(), 6) + ",";
    for (const double v :
         {pose.x(), pose.y(), pose.heading().radians(), sigma[0], sigma[1], sigma[2]})
      text += number(v);
    text += flag(s.converged) + number(s.mass) + std::to_string(s.clusters) + "," +
            std::to_string(s.particles) + "," + number(s.agreement) + flag(s.weighed) +
            flag(s.searched) + flag(s.relocalised) + flag(s.odometry_refused);
    const auto error = [](double v) { return std::isnan(v) ? "" : eval::fixed(v, 4); };
    text += error(errors.each.m[i]) + "," + error(errors.each.deg[i]) +
            (s.sensor == RangeSensor::radar ? ",radar\n" : ",lidar\n");
  }
  return text;
}

io::Plot plot_of(const std::string& title, const std::string& label,
                 const std::vector<double>& seconds, std::vector<io::Series> series) {
  io::Plot plot = io::time_plot(title, label);
  for (io::Series& s : series) {
    s.x = seconds;
    plot.series.push_back(std::move(s));
  }
  return plot;
}

template <class F>
std::vector<double> column(const LocalisationOutputs& o, const F& f) {
  std::vector<double> values;
  for (const LocalisationOutcome& outcome : o.run.outcomes) values.push_back(f(outcome));
  return values;
}

void add_pictures(io::Report& report, const LocalisationOutputs& o) {
  const LogTime start = o.run.outcomes.front().time;
  for (const ParticleSnapshot& shot : o.run.snapshots) {
    io::MapPainter painter(o.map);
    for (const PoseParticle& p : shot.particles) painter.dot(p.T_map_base.translation(), io::kRed);
    if (const auto truth = pose_at(o.truth.poses, shot.time))
      painter.dot(truth->translation(), io::kGreen, 9);
    report.image(painter.rows(),
                 std::to_string(shot.particles.size()) + " particles after " +
                     eval::fixed(to_seconds(shot.time - start), 1) + " s" +
                     (!o.truth.known() ? "." : "; the square is the true position."));
  }
  io::MapPainter painter(o.map);
  painter.path(points_of(o.truth.poses), io::kGreen);
  for (const Eigen::Vector2d& p : points_of(o.run.trajectory(true))) painter.dot(p, io::kBlue, 3);
  report.image(painter.rows(), !o.truth.known()
                                   ? "The converged poses."
                                   : "The true path and, in blue, the converged poses.");
}

io::Report report_of(const LocalisationOutputs& o) {
  io::Report report(o.title);
  report.doubt(o.doubt).facts(o.facts);
  const Errors errors = errors_of(o);
  for (const auto& [title, table] : localisation_errors(o)) report.heading(title).table(table);
  report.heading("Particles");
  add_pictures(report, o);
  report.heading("Over time");
  if (o.truth.known()) {
    report.plot(plot_of("Distance from the truth", "error [m]", errors.seconds,
                        {{"position", {}, errors.each.m}}));
    report.plot(plot_of("Error of the heading", "error [deg]", errors.seconds,
                        {{"heading", {}, errors.each.deg}}));
  }
  report.plot(plot_of("Number of particles", "particles", errors.seconds,
                      {{"particles", {}, column(o, [](const LocalisationOutcome& s) {
                          return static_cast<double>(s.particles);
                        })}}));
  report.plot(plot_of(
      "Confidence", "share", errors.seconds,
      {{"weight of the best cluster",
        {},
        column(o, [](const LocalisationOutcome& s) { return s.mass; })},
       {"agreement with the map",
        {},
        column(o, [](const LocalisationOutcome& s) { return s.weighed ? s.agreement : kNan; }),
        io::Mark::points}}));
  return report;
}

eval::Table scans_table(const LocalisationOutputs& o) {
  eval::Table table({{""},
                     {"scans"},
                     {"correct", "%"},
                     {"position RMSE", "m"},
                     {"median", "m"},
                     {"worst", "m"},
                     {"heading RMSE", "deg"}});
  const Errors errors = errors_of(o);
  const auto row = [&](const char* name, const ErrorList& e) {
    const Summary position = summarise(e.m), heading = summarise(e.deg);
    const std::size_t n = e.m.size();
    double correct = 0.0;
    for (std::size_t i = 0; i < n; ++i)
      correct += PoseError{e.m[i], e.deg[i]}.correct() ? 100.0 / static_cast<double>(n) : 0.0;
    table.add_row({name, std::to_string(n), eval::fixed(correct, 1), eval::fixed(position.rmse, 3),
                   eval::fixed(position.median, 3), eval::fixed(position.max, 3),
                   eval::fixed(heading.rmse, 2)});
  };
  row("converged poses", errors.converged);
  row("all", errors.all);
  return table;
}

}  // namespace

TitledTables localisation_errors(const LocalisationOutputs& o) {
  if (!o.truth.known()) return {};
  const Trajectory converged = o.run.trajectory(true), all = o.run.trajectory(false);
  TitledTables tables{{"Errors on the map", scans_table(o)}};
  const auto compared =
      error_tables(o.truth, compare(o.truth, {{"converged poses", converged}, {"all", all}}), true);
  tables.insert(tables.end(), compared.begin(), compared.end());
  return tables;
}

Result<void> write_localisation(const OutputArguments& to, const LocalisationOutputs& outputs) {
  return first_error(
      {io::write_tum(to.path("trajectory.tum"), outputs.run.trajectory(true), to.write()),
       io::write_file(to.path("poses.csv"), table_of_poses(outputs), to.write()),
       to.write_report(report_of(outputs))});
}

}  // namespace wayfare::examples
