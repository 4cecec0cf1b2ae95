#include "outputs.hpp"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

#include <wayfare/eval/table.hpp>
#include <wayfare/eval/trajectory_error.hpp>
#include <wayfare/io/report.hpp>
#include <wayfare/io/time_text.hpp>
#include <wayfare/io/tum.hpp>

#include "support/broken_at_wraps.hpp"

namespace wayfare::examples {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFiles[] = {"track.csv", "trajectory.tum", "report.html"};

std::string path_of(const std::string& folder, int file) {
  return (fs::path(folder) / kFiles[file]).string();
}

std::string csv(const WalkRun& run) {
  std::string out = "t_s,x_m,y_m,z_m,heading_deg,sigma_x_m,sigma_y_m,sigma_z_m,";
  out += run.foot ? "stride_m,statistic,stands\n" : "step_m,interval_s\n";
  for (const WalkRow& r : run.rows) {
    out += io::format_nanoseconds(r.time.nanoseconds());
    for (const double v : {r.position_m.x(), r.position_m.y(), r.position_m.z()})
      out += ',' + eval::fixed(v, 4);
    out += ',' + eval::fixed(r.heading.degrees(), 3);
    for (const double v : {r.sigma_m.x(), r.sigma_m.y(), r.sigma_m.z(), r.step_m})
      out += ',' + eval::fixed(v, 4);
    out += ',' + eval::fixed(run.foot ? r.still : r.interval_s, 3);
    if (run.foot) out += r.event ? ",1" : ",0";
    out += '\n';
  }
  return out;
}

io::Trajectory3 trajectory(const WalkRun& run) {
  io::Trajectory3 poses;
  for (const WalkRow& r : run.rows)
    poses.push_back({r.time, Transform3<frame::Map, frame::Base>(
                                 SE3d(r.position_m, SO3d::exp({0.0, 0.0, r.heading.radians()})))});
  return poses;
}

eval::Table summary(const WalkRun& run) {
  eval::Table table({{"walk"}, {""}});
  const WalkRow& end = run.rows.back();
  table.add_row({run.foot ? "stances" : "steps", std::to_string(run.events)});
  table.add_row({"length", eval::fixed(run.walked_m, 2) + " m"});
  table.add_row({"end", eval::fixed(end.position_m.norm(), 2) + " m from the start"});
  table.add_row({"end known to", eval::fixed(end.sigma_m.norm(), 2) + " m"});
  for (const auto& [what, found] : run.facts) table.add_row({what, found});
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
    s.x.push_back(seconds_of(run, r));
    s.y.push_back(value(r));
  }
  return s;
}

/// The resultant acceleration, and where in it steps were found.
io::Plot found_steps(const WalkRun& run) {
  io::Plot plot{"detected steps", "time [s]", "specific force [m/s^2]", {}, false};
  io::Series strength{"strength", {}, {}, io::Mark::line};
  io::Series steps{"steps", {}, {}, io::Mark::points};
  const auto& all = run.strength;
  for (const auto& [time, value] : all) {
    strength.x.push_back(to_seconds(time - run.rows.front().time));
    strength.y.push_back(value);
  }
  for (const WalkRow& r : run.rows) {
    const auto at = std::lower_bound(all.begin(), all.end(), r.time,
                                     [](const auto& s, LogTime t) { return s.first < t; });
    if (at == all.end()) continue;
    steps.x.push_back(seconds_of(run, r));
    steps.y.push_back(at->second);
  }
  plot.series = {strength, steps};
  return plot;
}

io::Plot way(const WalkRun& run) {
  io::Plot plot{"way", "x [m]", "y [m]", {}, true};
  io::Series line{"walked", {}, {}, io::Mark::line};
  io::Series start{"start", {0.0}, {0.0}, io::Mark::points};
  for (const WalkRow& r : run.rows) {
    line.x.push_back(r.position_m.x());
    line.y.push_back(r.position_m.y());
  }
  io::Series end{"end", {line.x.back()}, {line.y.back()}, io::Mark::points};
  plot.series = {line, start, end};
  return plot;
}

eval::AbsoluteError error_of(const WalkRun& run, const Trajectory& truth) {
  return eval::absolute_error(io::planar(trajectory(run)), truth);
}

eval::Table errors(const WalkRun& run, const Trajectory& truth) {
  const auto e = error_of(run, truth);
  eval::Table table({{"against the truth"}, {""}});
  table.add_row({"compared", std::to_string(e.times.size()) + " of " +
                                 std::to_string(run.rows.size()) + " positions"});
  if (e.times.empty()) return table;
  table.add_row({"root mean square, best rigid fit", eval::fixed(e.translation_m.rmse, 2) + " m"});
  table.add_row({"largest", eval::fixed(e.translation_m.max, 2) + " m"});
  table.add_row({"of the true length", eval::fixed(e.percent_of_path, 2) + " % of " +
                                           eval::fixed(e.path_length_m, 1) + " m"});
  return table;
}

/// The walk where it fits the truth best, and the truth.
io::Plot way_and_truth(const WalkRun& run, const Trajectory& truth) {
  const SE2d fit = error_of(run, truth).alignment;
  io::Plot plot{"way and truth", "x [m]", "y [m]", {}, true};
  io::Series walked{"walked", {}, {}, io::Mark::line}, known{"truth", {}, {}, io::Mark::dashed};
  for (const WalkRow& r : run.rows) {
    const Eigen::Vector2d p = fit * Eigen::Vector2d(r.position_m.head<2>());
    walked.x.push_back(p.x());
    walked.y.push_back(p.y());
  }
  for (const StampedPose& t : truth) {
    known.x.push_back(t.T_map_base.raw().translation().x());
    known.y.push_back(t.T_map_base.raw().translation().y());
  }
  plot.series = {walked, known};
  return plot;
}

io::Plot over_time(std::string title, std::string label, std::vector<io::Series> series) {
  return {std::move(title), "time [s]", std::move(label), std::move(series), false};
}

std::string report_html(const std::string& title, const WalkRun& run, const Trajectory& truth) {
  io::Report report(title, run.foot ? "dead reckoning by a unit on the foot"
                                    : "dead reckoning by steps, their lengths and the heading");
  report.table(summary(run), "The walk, and what became of the readings");
  if (!truth.empty()) report.table(errors(run, truth), "How far off it was");
  report.plot(truth.empty() ? way(run) : way_and_truth(run, truth));
  if (!run.foot) report.plot(found_steps(run));
  report.plot(over_time("heading", "angle [deg]",
                        {broken_at_wraps(curve(run, "walking", false, [](const WalkRow& r) {
                          return r.heading.degrees();
                        }))}));
  report.plot(over_time(run.foot ? "strides" : "steps", "length [m]",
                        {curve(run, "length", true, [](const WalkRow& r) { return r.step_m; })}));
  if (run.foot) {
    report.plot(over_time("height", "z [m]", {curve(run, "foot", false, [](const WalkRow& r) {
                            return r.position_m.z();
                          })}));
  } else {
    report.plot(
        over_time("time between steps", "interval [s]",
                  {curve(run, "interval", true, [](const WalkRow& r) { return r.interval_s; })}));
  }
  report.plot(over_time("standard deviation of the position", "sigma [m]",
                        {curve(run, "x", false, [](const WalkRow& r) { return r.sigma_m.x(); }),
                         curve(run, "y", false, [](const WalkRow& r) { return r.sigma_m.y(); })}));
  return report.html();
}

}  // namespace

std::string walk_text(const WalkRun& run, const Trajectory& truth) {
  return summary(run).to_text() + (truth.empty() ? "" : errors(run, truth).to_text());
}

Result<void> prepare_walk_folder(const std::string& folder, const io::WriteOptions& options) {
  std::error_code failed;
  fs::create_directories(folder, failed);
  if (failed) return Error{ErrorCode::io, "cannot be made: " + failed.message(), folder};
  if (options.existing == io::Existing::replace) return {};
  for (int i = 0; i < 3; ++i)
    if (fs::exists(path_of(folder, i)))
      return Error{ErrorCode::io, "is there already; --force overwrites it", path_of(folder, i)};
  return {};
}

Result<std::string> write_walk_outputs(const std::string& folder, const std::string& title,
                                       const WalkRun& run, const Trajectory& truth,
                                       const io::WriteOptions& options) {
  if (auto done = io::write_file(path_of(folder, 0), csv(run), options); !done) return done.error();
  if (auto done = io::write_tum(path_of(folder, 1), trajectory(run), options); !done)
    return done.error();
  if (auto done = io::write_file(path_of(folder, 2), report_html(title, run, truth), options);
      !done)
    return done.error();
  return path_of(folder, 2);
}

}  // namespace wayfare::examples
