#include "outputs.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include <wayfare/core/statistics.hpp>
#include <wayfare/io/report.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/io/tum.hpp>

namespace wayfare::examples {
namespace {

std::string csv(const WalkRun& run) {
  std::string out = "t_s,x_m,y_m,z_m,heading_deg,sigma_x_m,sigma_y_m,sigma_z_m,";
  out += run.foot ? "stride_m,statistic,stands" : "step_m,interval_s";
  out += run.pressure ? ",pressure_height_m,height_m,sigma_height_m\n" : "\n";
  for (const WalkRow& r : run.rows) {
    out += io::format_nanoseconds(r.time.nanoseconds());
    for (const double v : {r.position_m.x(), r.position_m.y(), r.position_m.z()})
      out += ',' + eval::fixed(v, 4);
    out += ',' + eval::fixed(r.heading.degrees(), 3);
    for (const double v : {r.sigma_m.x(), r.sigma_m.y(), r.sigma_m.z(), r.step_m})
      out += ',' + eval::fixed(v, 4);
    out += ',' + eval::fixed(run.foot ? r.still : r.interval_s, 3);
    if (run.foot) out += r.event ? ",1" : ",0";
    if (run.pressure)
      for (const double v : {r.pressure_height_m, r.height_m, r.height_sigma_m})
        out += ',' + eval::fixed(v, 4);
    out += '\n';
  }
  return out;
}

io::Trajectory3 trajectory(const WalkRun& run) {
  io::Trajectory3 poses;
  for (const WalkRow& r : run.rows) {
    const double z = run.pressure ? r.height_m : r.position_m.z();
    poses.push_back({r.time, Transform3<frame::Map, frame::Base>(
                                 SE3d({r.position_m.x(), r.position_m.y(), z},
                                      SO3d::exp({0.0, 0.0, r.heading.radians()})))});
  }
  return poses;
}

eval::Table summary(const WalkRun& run) {
  eval::Table table({{"walk"}, {""}});
  const WalkRow& end = run.rows.back();
  table.add_row({run.foot ? "stances" : "steps", std::to_string(run.events)});
  table.add_row({"length", eval::fixed(run.walked_m, 2) + " m"});
  table.add_row({"end", eval::fixed(end.position_m.norm(), 2) + " m from the start"});
  table.add_row({"sigma at the end", eval::fixed(end.sigma_m.norm(), 2) + " m"});
  for (const auto& [name, value] : run.facts) table.add_row({name, value});
  return table;
}

double seconds_of(const WalkRun& run, const WalkRow& row) {
  return to_seconds(row.time - run.rows.front().time);
}

template <class Value>
io::Series curve(const WalkRun& run, std::string name, bool events_only, Value value) {
  io::Series s{std::move(name), {}, {}, events_only ? io::Mark::points : io::Mark::line};
  for (const WalkRow& r : run.rows) {
    if (events_only && !r.event) continue;
    s.add(seconds_of(run, r), value(r));
  }
  return s;
}

/// The norm of the specific force with the detected steps.
io::Plot steps_plot(const WalkRun& run) {
  io::Plot plot = io::time_plot("detected steps", "specific force [m/s^2]");
  io::Series force{"norm", {}, {}};
  io::Series steps{"steps", {}, {}, io::Mark::points};
  const auto& all = run.force;
  for (const auto& [time, value] : all) force.add(to_seconds(time - run.rows.front().time), value);
  for (const WalkRow& r : run.rows) {
    const auto at = std::lower_bound(all.begin(), all.end(), r.time,
                                     [](const auto& s, LogTime t) { return s.first < t; });
    if (at != all.end()) steps.add(seconds_of(run, r), at->second);
  }
  plot.series = {force, steps};
  return plot;
}

std::vector<eval::Evaluated> errors_of(const WalkRun& run, const Truth& truth) {
  const Trajectory walk = io::planar(trajectory(run));
  return compare(truth, {{"walk", walk}});
}

/// As x, for their interpolation.
Trajectory heights_of(const Truth& truth) {
  Trajectory heights;
  for (std::size_t i = 0; i < truth.heights_m.size(); ++i)
    heights.push_back({truth.poses[i].time, Transform2<frame::Map, frame::Base>(
                                                SE2d(truth.heights_m[i], 0.0, Angle()))});
  return heights;
}

/// Of a height against the true one, both from the first row that the truth covers.
struct HeightError {
  double rms_m = 0.0, end_m = 0.0;
};
template <class Height>
std::optional<HeightError> height_error(const WalkRun& run, const Trajectory& truth,
                                        const Height& height) {
  std::optional<double> start;
  std::vector<double> errors;
  for (const WalkRow& r : run.rows) {
    const auto expected = pose_at(truth, r.time);
    if (!expected) continue;
    const double off = height(r) - expected->x();
    if (!start) start = off;
    errors.push_back(off - *start);
  }
  if (errors.empty()) return std::nullopt;
  return HeightError{summarise(errors).rmse, std::abs(errors.back())};
}

/// Without rows if neither the walk nor the truth has heights.
eval::Table height_errors(const WalkRun& run, const Truth& truth) {
  eval::Table table({{"height"}, {"RMSE", "m"}, {"end", "m"}});
  const Trajectory heights = heights_of(truth);
  const auto row = [&](const std::string& name, const auto& height) {
    if (const auto e = height_error(run, heights, height))
      table.add_row({"by " + name, eval::fixed(e->rms_m, 2), eval::fixed(e->end_m, 2)});
  };
  if (run.foot) row("the foot", [](const WalkRow& r) { return r.position_m.z(); });
  if (!run.pressure) return table;
  row("pressure", [](const WalkRow& r) { return r.pressure_height_m; });
  row(run.foot ? "both" : "pressure, filtered", [](const WalkRow& r) { return r.height_m; });
  return table;
}

TitledTables tables_of(const WalkRun& run, const Truth& truth,
                       const std::vector<eval::Evaluated>& errors) {
  TitledTables tables = error_tables(truth, errors);
  const bool heights = !truth.heights_m.empty() && (run.foot || run.pressure);
  if (heights)
    tables.emplace_back("Errors of heights, from the same start", height_errors(run, truth));
  return tables;
}

io::Plot path_plot(const WalkRun& run, const Truth& truth,
                   const std::vector<eval::Evaluated>& errors) {
  io::Plot plot = io::top_view("path");
  io::Series line{"estimate", {}, {}};
  io::Series start{"start", {0.0}, {0.0}, io::Mark::points};
  for (const WalkRow& r : run.rows) line.add(r.position_m.x(), r.position_m.y());
  io::Series end{"end", {line.x.back()}, {line.y.back()}, io::Mark::points};
  plot.series = {line, start, end};
  if (!errors.empty()) plot.series.push_back(truth_series(truth, errors.front().errors));
  return plot;
}

io::Plot over_time(std::string title, std::string label, std::vector<io::Series> series) {
  return {std::move(title), "time [s]", std::move(label), std::move(series), false};
}

/// Heights of the foot, by pressure and of both, with the truth.
io::Plot height_plot(const WalkRun& run, const Truth& truth) {
  io::Plot plot = io::time_plot("height", "z [m]");
  const auto add = [&](const char* name, auto value) {
    plot.series.push_back(curve(run, name, false, value));
  };
  if (run.pressure) {
    add("pressure", [](const WalkRow& r) { return r.pressure_height_m; });
    add(run.foot ? "both" : "filtered", [](const WalkRow& r) { return r.height_m; });
  }
  if (run.foot) add("foot", [](const WalkRow& r) { return r.position_m.z(); });
  if (truth.heights_m.empty()) return plot;
  io::Series line{"truth", {}, {}, io::Mark::dashed};
  for (std::size_t i = 0; i < truth.heights_m.size(); ++i)
    line.add(to_seconds(truth.poses[i].time - run.rows.front().time),
             truth.heights_m[i] - truth.heights_m.front());
  plot.series.push_back(std::move(line));
  return plot;
}

io::Report report_of(const std::string& title, const WalkRun& run, const Truth& truth) {
  io::Report report(title, run.foot ? "dead reckoning by a unit on the foot"
                                    : "dead reckoning by steps, their lengths and the heading");
  report.table(summary(run), "Walk and use of the readings");
  const std::vector<eval::Evaluated> errors = errors_of(run, truth);
  for (const auto& [title_of_table, table] : tables_of(run, truth, errors))
    report.table(table, title_of_table);
  report.plot(path_plot(run, truth, errors));
  for (const io::Plot& plot : distance_plots(truth, errors)) report.plot(plot);
  if (!run.foot) report.plot(steps_plot(run));
  report.plot(over_time("heading", "angle [deg]",
                        {io::broken_at_wraps(curve(run, "heading", false, [](const WalkRow& r) {
                          return r.heading.degrees();
                        }))}));
  report.plot(over_time(run.foot ? "strides" : "steps", "length [m]",
                        {curve(run, "length", true, [](const WalkRow& r) { return r.step_m; })}));
  if (run.foot || run.pressure) report.plot(height_plot(run, truth));
  if (!run.foot)
    report.plot(
        over_time("time between steps", "interval [s]",
                  {curve(run, "interval", true, [](const WalkRow& r) { return r.interval_s; })}));
  report.plot(over_time("standard deviation of the position", "sigma [m]",
                        {curve(run, "x", false, [](const WalkRow& r) { return r.sigma_m.x(); }),
                         curve(run, "y", false, [](const WalkRow& r) { return r.sigma_m.y(); })}));
  return report;
}

}  // namespace

std::string walk_text(const WalkRun& run, const Truth& truth) {
  const std::string errors = to_text(tables_of(run, truth, errors_of(run, truth)));
  return summary(run).to_text() + errors + (errors.empty() ? "" : "\n");
}

Result<void> write_walk_outputs(const OutputArguments& to, const std::string& title,
                                const WalkRun& run, const Truth& truth) {
  return first_error({io::write_file(to.path("track.csv"), csv(run), to.write()),
                      io::write_tum(to.path("trajectory.tum"), trajectory(run), to.write()),
                      to.write_report(report_of(title, run, truth))});
}

}  // namespace wayfare::examples
