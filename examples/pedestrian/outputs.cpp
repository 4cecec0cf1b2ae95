#include "outputs.hpp"

#include <filesystem>
#include <system_error>
#include <utility>

#include <wayfare/eval/table.hpp>
#include <wayfare/io/report.hpp>
#include <wayfare/io/time_text.hpp>
#include <wayfare/io/tum.hpp>

#include "broken_at_wraps.hpp"

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

io::Plot over_time(std::string title, std::string label, std::vector<io::Series> series) {
  return {std::move(title), "time [s]", std::move(label), std::move(series), false};
}

std::string report_html(const std::string& title, const WalkRun& run) {
  io::Report report(title, run.foot ? "dead reckoning by a unit on the foot"
                                    : "dead reckoning by steps, their lengths and the heading");
  report.table(summary(run), "The walk, and what became of the readings");
  report.plot(way(run));
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

std::string walk_text(const WalkRun& run) { return summary(run).to_text(); }

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
                                       const WalkRun& run, const io::WriteOptions& options) {
  if (auto done = io::write_file(path_of(folder, 0), csv(run), options); !done) return done.error();
  if (auto done = io::write_tum(path_of(folder, 1), trajectory(run), options); !done)
    return done.error();
  if (auto done = io::write_file(path_of(folder, 2), report_html(title, run), options); !done)
    return done.error();
  return path_of(folder, 2);
}

}  // namespace wayfare::examples
