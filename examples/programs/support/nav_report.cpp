#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include <wayfare/core/se3.hpp>
#include <wayfare/io/report.hpp>

#include "degree.hpp"
#include "nav_outputs.hpp"

namespace wayfare::examples {
namespace {

const char* name_of_plain(const NavOutputs& run) {
  return run.recording.recording.ranges.empty() ? "fixes" : "plain GNSS";
}

void extend(io::Series& series, const Geodetic& position, const Geodetic& origin) {
  const Eigen::Vector3d ned = ned_from_geodetic(position, origin);
  series.add(ned.y(), ned.x());
}

io::Plot track_plot(const NavOutputs& run, const NavFindings& f) {
  const Geodetic origin = run.run.points.front().nav.position;
  io::Plot plot{"Track", "east [m]", "north [m]", {}, true};
  io::Series filter{"filter", {}, {}};
  for (std::size_t i = 0; i < run.run.points.size(); i += 10)
    extend(filter, run.run.points[i].nav.position, origin);
  plot.series.push_back(std::move(filter));
  io::Series plain{name_of_plain(run), {}, {}, io::Mark::points};
  for (const Geodetic& p : f.plain.position) extend(plain, p, origin);
  plot.series.push_back(std::move(plain));
  if (!run.recording.truth.states.empty()) {
    io::Series truth{
        run.config.truth_is_true ? "reference" : "other solution", {}, {}, io::Mark::dashed};
    for (const NavState& s : run.recording.truth.states) extend(truth, s.position, origin);
    plot.series.push_back(std::move(truth));
  }
  return plot;
}

io::Plot error_plot(const eval::NavErrors& errors, std::size_t axis, const std::string& title,
                    const std::string& unit) {
  io::Plot plot = io::time_plot(title, unit);
  io::Series error{"error", errors.time_s, errors.error[axis]};
  io::Series upper{"\u00b13\u03c3", errors.time_s, {}};
  for (const double s : errors.sigma[axis]) upper.y.push_back(3.0 * s);
  plot.series = {std::move(error), io::bounds_series(upper)};
  return plot;
}

void add_errors(io::Report& report, const NavOutputs& run, const NavFindings& f) {
  const bool truth = run.config.truth_is_true;
  report.heading(truth ? "Errors against the reference, with the filter's bounds"
                       : "Differences from another solution");
  if (!truth) report.paragraph("The reference is another solution with errors of its own.");
  constexpr std::array<const char*, eval::NavErrors::kCount> kTitles = {
      "North", "East",  "Down", "Velocity north", "Velocity east", "Velocity down",
      "Roll",  "Pitch", "Yaw"};
  constexpr std::array<const char*, 3> kUnits = {"[m]", "[m/s]", "[deg]"};
  for (std::size_t k = 0; k < eval::NavErrors::kCount; ++k) {
    const auto& e = f.errors.error[k];
    if (std::none_of(e.begin(), e.end(), [](double v) { return std::isfinite(v); })) continue;
    report.plot(error_plot(f.errors, k, kTitles[k], kUnits[k / 3]));
  }
  io::Plot horizontal = io::time_plot("Horizontal error", "[m]");
  io::Series filter{"filter", f.errors.time_s, {}};
  for (std::size_t i = 0; i < f.errors.time_s.size(); ++i)
    filter.y.push_back(f.errors.horizontal(i));
  io::Series plain{name_of_plain(run), f.plain.time_s, {}, io::Mark::points};
  for (const Eigen::Vector3d& v : f.plain.error_ned_m) plain.y.push_back(v.head<2>().norm());
  horizontal.series = {std::move(filter), std::move(plain)};
  report.plot(horizontal);
}

void add_innovations(io::Report& report, const NavOutputs& run) {
  for (const auto& [kinds, title] :
       {std::pair{std::pair{InnovationRecord::Kind::range, InnovationRecord::Kind::position},
                  "Innovations of ranges and positions"},
        std::pair{std::pair{InnovationRecord::Kind::range_rate, InnovationRecord::Kind::velocity},
                  "Innovations of range rates and velocities"}}) {
    io::Plot plot = io::time_plot(title, "[\u03c3]");
    io::Series accepted{"accepted", {}, {}, io::Mark::points},
        refused{"refused", {}, {}, io::Mark::points};
    for (const InnovationRecord& r : run.run.innovations) {
      if (r.kind != kinds.first && r.kind != kinds.second) continue;
      io::Series& s = r.accepted ? accepted : refused;
      // Clamped: a range error of kilometres must not flatten the others.
      s.add(run.seconds(r.time), std::clamp(r.innovation / r.sigma, -12.0, 12.0));
    }
    if (accepted.x.empty() && refused.x.empty()) continue;
    plot.series = {std::move(accepted), std::move(refused)};
    report.plot(plot);
  }
}

io::Plot satellites_plot(const NavOutputs& run) {
  io::Plot plot = io::time_plot("Satellites", "number");
  io::Series offered{"measured", {}, {}}, used{"used", {}, {}};
  std::map<LogTime, double> accepted;
  for (const InnovationRecord& r : run.run.innovations)
    if (r.kind == InnovationRecord::Kind::range) accepted[r.time] += r.accepted ? 1.0 : 0.0;
  for (const RangeEpoch& e : run.recording.recording.ranges) {
    const double t = run.seconds(e.time);
    offered.add(t, static_cast<double>(e.satellites.size()));
    const auto found = accepted.find(e.time);
    used.add(t, found == accepted.end() ? 0.0 : found->second);
  }
  plot.series = {std::move(offered), std::move(used)};
  return plot;
}

/// Components of a quantity over time, every half second.
template <class Get>
io::Plot states_plot(const NavOutputs& run, const char* title, const char* unit,
                     const std::vector<std::string>& names, Get get) {
  io::Plot plot = io::time_plot(title, unit);
  for (const std::string& name : names) plot.series.push_back({name, {}, {}});
  double next = -1e300;
  for (const GnssInsPoint& p : run.run.points) {
    const double t = run.seconds(p.nav.time);
    if (t < next) continue;
    next = t + 0.5;
    for (std::size_t k = 0; k < names.size(); ++k)
      plot.series[k].add(t, get(p, static_cast<Eigen::Index>(k)));
  }
  return plot;
}

void add_states(io::Report& report, const NavOutputs& run) {
  report.heading("Filter states");
  using Point = const GnssInsPoint&;
  using Index = Eigen::Index;
  const std::vector<std::string> axes = {"x", "y", "z"};
  const auto add = [&](const char* title, const char* unit, const std::vector<std::string>& names,
                       auto get) { report.plot(states_plot(run, title, unit, names, get)); };
  add("Velocity", "[m/s]", {"north", "east", "down"},
      [](Point p, Index k) { return p.nav.velocity_ned_mps[k]; });
  add("Attitude", "[deg]", {"roll", "pitch", "yaw"},
      [](Point p, Index k) { return roll_pitch_yaw_rad(p.nav.q_nb)[k] / kDegree; });
  add("Gyro bias", "[deg/s]", axes,
      [](Point p, Index k) { return static_cast<double>(p.imu_errors[k]) / kDegree; });
  add("Gyro bias, \u03c3", "[deg/s]", axes, [](Point p, Index k) {
    return static_cast<double>(p.sigma[ins_state::kGyroBias + k]) / kDegree;
  });
  add("Accelerometer bias", "[m/s\u00b2]", axes,
      [](Point p, Index k) { return static_cast<double>(p.imu_errors[3 + k]); });
  add("Accelerometer bias, \u03c3", "[m/s\u00b2]", axes,
      [](Point p, Index k) { return static_cast<double>(p.sigma[ins_state::kAccelBias + k]); });
  if (!run.recording.recording.ranges.empty())
    add("Receiver clock drift", "[m/s]", {"drift"},
        [](Point p, Index) { return p.clock_drift_mps; });
}

eval::Table remarks_table(const NavOutputs& run) {
  eval::Table table({{"remark"}, {"time", "s"}});
  for (const std::string& text : run.recording.remarks) table.add_row({text, "reading"});
  constexpr std::size_t kShown = 40;
  const auto& notices = run.run.notices;
  for (std::size_t i = 0; i < notices.size() && i < kShown; ++i)
    table.add_row({notices[i].text, eval::fixed(run.seconds(notices[i].time), 2)});
  if (notices.size() > kShown)
    table.add_row({"and " + std::to_string(notices.size() - kShown) + " more", ""});
  return table;
}

}  // namespace

io::Report report_of(const NavOutputs& run, const NavFindings& f) {
  io::Report report(run.title, run.config.note);
  report.doubt(f.doubt.why).facts(f.facts);
  for (const auto& [title, table] : f.tables) report.heading(title).table(table);
  report.heading("Track").plot(track_plot(run, f));
  if (!f.errors.time_s.empty()) add_errors(report, run, f);
  report.heading("Measurements");
  add_innovations(report, run);
  if (!run.recording.recording.ranges.empty()) report.plot(satellites_plot(run));
  add_states(report, run);
  const eval::Table remarks = remarks_table(run);
  if (!remarks.rows().empty()) report.heading("Remarks").table(remarks);
  return report;
}

}  // namespace wayfare::examples
