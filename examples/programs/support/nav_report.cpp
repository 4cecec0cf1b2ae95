#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include <wayfare/core/roll_pitch_yaw.hpp>

#include "nav_outputs.hpp"
#include "time_plot.hpp"

namespace wayfare::examples {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

io::Series track(std::string name, io::Mark mark) { return {std::move(name), {}, {}, mark}; }

void extend(io::Series& series, const Geodetic& position, const Geodetic& origin) {
  const Eigen::Vector3d ned = ned_from_geodetic(position, origin);
  series.x.push_back(ned.y());
  series.y.push_back(ned.x());
}

io::Plot track_plot(const NavOutputs& run, const NavFindings& f) {
  const Geodetic origin = run.run.points.front().nav.position;
  io::Plot plot;
  plot.title = "Track";
  plot.x_label = "east [m]";
  plot.y_label = "north [m]";
  plot.equal_aspect = true;
  io::Series filter = track("filter", io::Mark::line);
  for (std::size_t i = 0; i < run.run.points.size(); i += 10)
    extend(filter, run.run.points[i].nav.position, origin);
  plot.series.push_back(std::move(filter));
  io::Series plain =
      track(run.recording.recording.ranges.empty() ? "fixes" : "plain GNSS", io::Mark::points);
  for (const Geodetic& p : f.plain.position) extend(plain, p, origin);
  plot.series.push_back(std::move(plain));
  if (!run.recording.truth.empty()) {
    io::Series truth =
        track(run.config.truth_is_true ? "reference" : "other solution", io::Mark::dashed);
    for (const NavState& s : run.recording.truth) extend(truth, s.position, origin);
    plot.series.push_back(std::move(truth));
  }
  return plot;
}

io::Plot error_plot(const NavErrors& errors, std::size_t axis, const std::string& title,
                    const std::string& unit) {
  io::Plot plot = time_plot(title, unit);
  io::Series error{"error", errors.time_s, errors.error[axis]};
  io::Series upper{"\u00b13\u03c3", errors.time_s, {}, io::Mark::dashed}, lower = upper;
  for (const double s : errors.sigma[axis]) upper.y.push_back(3.0 * s), lower.y.push_back(-3.0 * s);
  // One curve with a break: both bounds share a colour and a line in the legend.
  upper.x.push_back(kNan), upper.y.push_back(kNan);
  upper.x.insert(upper.x.end(), lower.x.begin(), lower.x.end());
  upper.y.insert(upper.y.end(), lower.y.begin(), lower.y.end());
  plot.series = {std::move(error), std::move(upper)};
  return plot;
}

void add_errors(io::Report& report, const NavOutputs& run, const NavFindings& f) {
  const bool truth = run.config.truth_is_true;
  report.heading(truth ? "Errors against the reference, with the filter's own bounds"
                       : "Differences from another solution");
  if (!truth)
    report.paragraph("What is compared here is another solution, not the truth: it errs too.");
  constexpr std::array<const char*, NavErrors::kCount> kTitles = {
      "North", "East",  "Down", "Velocity north", "Velocity east", "Velocity down",
      "Roll",  "Pitch", "Yaw"};
  constexpr std::array<const char*, 3> kUnits = {"[m]", "[m/s]", "[deg]"};
  for (std::size_t k = 0; k < NavErrors::kCount; ++k) {
    const auto& e = f.errors.error[k];
    if (std::none_of(e.begin(), e.end(), [](double v) { return std::isfinite(v); })) continue;
    report.plot(error_plot(f.errors, k, kTitles[k], kUnits[k / 3]));
  }
  io::Plot horizontal = time_plot("Horizontal error", "[m]");
  io::Series filter{"filter", f.errors.time_s, {}};
  for (std::size_t i = 0; i < f.errors.time_s.size(); ++i)
    filter.y.push_back(f.errors.horizontal(i));
  io::Series plain{run.recording.recording.ranges.empty() ? "fixes" : "plain GNSS",
                   f.plain.time_s,
                   {},
                   io::Mark::points};
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
    io::Plot plot = time_plot(title, "[\u03c3]");
    io::Series accepted{"accepted", {}, {}, io::Mark::points},
        refused{"refused", {}, {}, io::Mark::points};
    for (const InnovationRecord& r : run.run.innovations) {
      if (r.kind != kinds.first && r.kind != kinds.second) continue;
      io::Series& s = r.accepted ? accepted : refused;
      s.x.push_back(since_start(run.recording, r.time));
      // A range off by kilometres must not flatten all the others.
      s.y.push_back(std::clamp(r.innovation / r.sigma, -12.0, 12.0));
    }
    if (accepted.x.empty() && refused.x.empty()) continue;
    plot.series = {std::move(accepted), std::move(refused)};
    report.plot(plot);
  }
}

io::Plot satellites_plot(const NavOutputs& run) {
  io::Plot plot = time_plot("Satellites", "number");
  io::Series offered{"measured", {}, {}}, used{"used", {}, {}};
  std::map<LogTime, double> accepted;
  for (const InnovationRecord& r : run.run.innovations)
    if (r.kind == InnovationRecord::Kind::range) accepted[r.time] += r.accepted ? 1.0 : 0.0;
  for (const RangeEpoch& e : run.recording.recording.ranges) {
    offered.x.push_back(since_start(run.recording, e.time));
    offered.y.push_back(static_cast<double>(e.satellites.size()));
    const auto found = accepted.find(e.time);
    used.x.push_back(offered.x.back());
    used.y.push_back(found == accepted.end() ? 0.0 : found->second);
  }
  plot.series = {std::move(offered), std::move(used)};
  return plot;
}

/// Three of the run's quantities over time, a point a second.
template <class Get>
io::Plot states_plot(const NavOutputs& run, const char* title, const char* unit,
                     const std::vector<std::string>& names, Get get) {
  io::Plot plot = time_plot(title, unit);
  for (const std::string& name : names) plot.series.push_back({name, {}, {}});
  double next = -1e300;
  for (const GnssInsPoint& p : run.run.points) {
    const double t = since_start(run.recording, p.nav.time);
    if (t < next) continue;
    next = t + 0.5;
    for (std::size_t k = 0; k < names.size(); ++k) {
      plot.series[k].x.push_back(t);
      plot.series[k].y.push_back(get(p, static_cast<Eigen::Index>(k)));
    }
  }
  return plot;
}

void add_states(io::Report& report, const NavOutputs& run) {
  report.heading("The filter's states");
  report.plot(
      states_plot(run, "Velocity", "[m/s]", {"north", "east", "down"},
                  [](const GnssInsPoint& p, Eigen::Index k) { return p.nav.velocity_ned_mps[k]; }));
  report.plot(states_plot(run, "Attitude", "[deg]", {"roll", "pitch", "yaw"},
                          [](const GnssInsPoint& p, Eigen::Index k) {
                            return roll_pitch_yaw_rad(p.nav.q_nb)[k] / kDegree;
                          }));
  report.plot(states_plot(run, "Gyro bias", "[deg/s]", {"x", "y", "z"},
                          [](const GnssInsPoint& p, Eigen::Index k) {
                            return static_cast<double>(p.imu_errors[k]) / kDegree;
                          }));
  report.plot(states_plot(run, "Gyro bias, \u03c3", "[deg/s]", {"x", "y", "z"},
                          [](const GnssInsPoint& p, Eigen::Index k) {
                            return static_cast<double>(p.sigma[ins_state::kGyroBias + k]) / kDegree;
                          }));
  report.plot(states_plot(run, "Accelerometer bias", "[m/s\u00b2]", {"x", "y", "z"},
                          [](const GnssInsPoint& p, Eigen::Index k) {
                            return static_cast<double>(p.imu_errors[3 + k]);
                          }));
  report.plot(states_plot(run, "Accelerometer bias, \u03c3", "[m/s\u00b2]", {"x", "y", "z"},
                          [](const GnssInsPoint& p, Eigen::Index k) {
                            return static_cast<double>(p.sigma[ins_state::kAccelBias + k]);
                          }));
  if (run.recording.recording.ranges.empty()) return;
  report.plot(states_plot(run, "Receiver clock drift", "[m/s]", {"drift"},
                          [](const GnssInsPoint& p, Eigen::Index) { return p.clock_drift_mps; }));
}

eval::Table remarks_table(const NavOutputs& run) {
  eval::Table table({{"what"}, {"when", "s"}});
  for (const std::string& text : run.recording.remarks) table.add_row({text, "reading"});
  constexpr std::size_t kShown = 40;
  const auto& notices = run.run.notices;
  for (std::size_t i = 0; i < notices.size() && i < kShown; ++i)
    table.add_row({notices[i].text, eval::fixed(since_start(run.recording, notices[i].time), 2)});
  if (notices.size() > kShown)
    table.add_row({"and " + std::to_string(notices.size() - kShown) + " more", ""});
  return table;
}

}  // namespace

io::Report report_of(const NavOutputs& run, const NavFindings& f) {
  io::Report report(run.title, run.config.note);
  report.facts(f.facts);
  for (const auto& [title, table] : f.tables) report.heading(title).table(table);
  report.heading("Track").plot(track_plot(run, f));
  if (!f.errors.time_s.empty()) add_errors(report, run, f);
  report.heading("Measurements");
  add_innovations(report, run);
  if (!run.recording.recording.ranges.empty()) report.plot(satellites_plot(run));
  add_states(report, run);
  const eval::Table remarks = remarks_table(run);
  if (!remarks.rows().empty()) report.heading("What was met and survived").table(remarks);
  return report;
}

}  // namespace wayfare::examples
