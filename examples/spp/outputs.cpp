#include "outputs.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <set>
#include <system_error>

#include <wayfare/eval/statistics.hpp>
#include <wayfare/gnss/signal.hpp>
#include <wayfare/io/nav_text.hpp>
#include <wayfare/io/report.hpp>
#include <wayfare/io/tum.hpp>

namespace wayfare::examples {
namespace {

namespace fs = std::filesystem;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// The reference between its two samples around `time`.
std::optional<NavState> reference_at(const NavTrajectory& truth, LogTime time) {
  const auto after =
      std::upper_bound(truth.begin(), truth.end(), time,
                       [](LogTime t, const NavState& state) { return t < state.time; });
  if (after == truth.begin()) return std::nullopt;
  const NavState& a = *(after - 1);
  if (after == truth.end()) return a.time == time ? std::optional(a) : std::nullopt;
  const NavState& b = *after;
  if (b.time - a.time > std::chrono::seconds(2)) return std::nullopt;
  const double w = to_seconds(time - a.time) / to_seconds(b.time - a.time);
  NavState state = a;
  state.time = time;
  state.position = geodetic_from_ecef((1.0 - w) * ecef_from_geodetic(a.position) +
                                      w * ecef_from_geodetic(b.position));
  state.velocity_ned_mps = (1.0 - w) * a.velocity_ned_mps + w * b.velocity_ned_mps;
  return state;
}

struct Errors {
  std::vector<double> horizontal, vertical, speed;
};

void take(const PositionError& e, Errors& errors) {
  errors.horizontal.push_back(e.ned_m.head<2>().norm());
  errors.vertical.push_back(std::abs(e.ned_m.z()));
  if (e.velocity_ned_mps) errors.speed.push_back(e.velocity_ned_mps->norm());
}

double quantile(std::vector<double> values, double part) {
  if (values.empty()) return kNone;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(part * static_cast<double>(values.size() - 1))];
}

void add_row(eval::Table& table, const std::string& name, const Errors& e) {
  const eval::Summary h = eval::summarise(e.horizontal), v = eval::summarise(e.vertical);
  table.add_row({name, std::to_string(h.count), eval::fixed(h.rmse, 3), eval::fixed(h.median, 3),
                 eval::fixed(quantile(e.horizontal, 0.95), 2), eval::fixed(h.max, 2),
                 eval::fixed(v.rmse, 3), eval::fixed(eval::summarise(e.speed).rmse, 3)});
}

/// A peer's time of an epoch, to the nearest second: receivers' clocks are milliseconds off.
std::int64_t second_of(LogTime t) { return (t.nanoseconds() + 500'000'000) / 1'000'000'000; }

LogTime start_of(const SppRun& run) { return run.points.front().instant; }
double since_start(const SppRun& run, LogTime t) { return to_seconds(t - start_of(run)); }

io::Plot track_plot(const SppRun& run) {
  const Geodetic origin = run.points.front().position;
  io::Plot plot{"Track", "east [m]", "north [m]", {}, true};
  io::Series track{"single points", {}, {}, io::Mark::points};
  for (const SinglePoint& p : run.points) {
    const Eigen::Vector3d ned = ned_from_geodetic(p.position, origin);
    track.x.push_back(ned.y());
    track.y.push_back(ned.x());
  }
  plot.series.push_back(std::move(track));
  if (run.truth.empty()) return plot;
  io::Series truth{"reference", {}, {}, io::Mark::line};
  for (const NavState& s : run.truth) {
    const bool during = s.time >= start_of(run) && s.time <= run.points.back().instant;
    const Eigen::Vector3d ned = ned_from_geodetic(s.position, origin);
    truth.x.push_back(during ? ned.y() : kNone);
    truth.y.push_back(during ? ned.x() : kNone);
  }
  plot.series.push_back(std::move(truth));
  return plot;
}

io::Plot errors_plot(const SppRun& run, const std::vector<PositionError>& errors, int axis) {
  constexpr const char* kAxes[] = {"North", "East", "Down"};
  io::Plot plot{std::string(kAxes[axis]) + " error and its 3σ bounds", "time [s]", "error [m]", {}};
  io::Series error{"error", {}, {}}, above{"+3σ", {}, {}, io::Mark::dashed},
      below{"−3σ", {}, {}, io::Mark::dashed};
  LogTime last = errors.front().time;
  for (const PositionError& e : errors) {
    const bool gap = e.time - last > std::chrono::seconds(3);
    for (io::Series* s : {&error, &above, &below}) {
      if (gap) s->x.push_back(since_start(run, last)), s->y.push_back(kNone);
      s->x.push_back(since_start(run, e.time));
    }
    last = e.time;
    error.y.push_back(e.ned_m[axis]);
    above.y.push_back(3.0 * e.sigma_m[axis]);
    below.y.push_back(-3.0 * e.sigma_m[axis]);
  }
  plot.series = {std::move(error), std::move(above), std::move(below)};
  return plot;
}

io::Plot satellites_plot(const SppRun& run) {
  io::Plot plot{"Satellites", "time [s]", "number", {}};
  io::Series seen{"with a range", {}, {}, io::Mark::points}, used{"used", {}, {}, io::Mark::points};
  for (const SinglePoint& p : run.points) {
    const auto measured = std::count_if(p.residuals.begin(), p.residuals.end(),
                                        [](const auto& r) { return std::isfinite(r.range_m); });
    seen.x.push_back(since_start(run, p.instant));
    seen.y.push_back(static_cast<double>(measured));
    used.x.push_back(seen.x.back());
    used.y.push_back(p.used);
  }
  plot.series = {std::move(seen), std::move(used)};
  return plot;
}

io::Plot residuals_plot(const SppRun& run) {
  io::Plot plot{"Range residuals, in standard deviations", "time [s]", "residual / σ", {}};
  io::Series used{"used", {}, {}, io::Mark::points}, out{"left out", {}, {}, io::Mark::points};
  for (const SinglePoint& p : run.points) {
    for (const SatelliteResidual& r : p.residuals) {
      if (!std::isfinite(r.range_m)) continue;
      io::Series& series = r.range_used ? used : out;
      series.x.push_back(since_start(run, p.instant));
      series.y.push_back(std::clamp(r.range_m / r.range_sigma_m, -30.0, 30.0));
    }
  }
  plot.series = {std::move(used), std::move(out)};
  return plot;
}

/// The zenith in the middle, the horizon at 90.
io::Plot sky_plot(const SppRun& run) {
  io::Plot plot{"Sky: distance from the zenith, north up", "east [deg]", "north [deg]", {}, true};
  std::map<GnssSystem, io::Series> series;
  for (const SinglePoint& p : run.points) {
    for (const SatelliteResidual& r : p.residuals) {
      io::Series& s = series[r.satellite.system];
      const double zenith = 90.0 - Angle::radians(r.sight.elevation_rad).degrees();
      s.x.push_back(zenith * std::sin(r.sight.azimuth_rad));
      s.y.push_back(zenith * std::cos(r.sight.azimuth_rad));
    }
  }
  for (auto& [system, s] : series) {
    s.name = name_of(system);
    s.mark = io::Mark::points;
    plot.series.push_back(std::move(s));
  }
  io::Series horizon{"horizon and 45°", {}, {}, io::Mark::dashed};
  for (const double zenith : {90.0, 45.0}) {
    for (int degrees = 0; degrees <= 360; degrees += 5) {
      const double a = Angle::degrees(degrees).radians();
      horizon.x.push_back(zenith * std::sin(a));
      horizon.y.push_back(zenith * std::cos(a));
    }
    horizon.x.push_back(kNone);
    horizon.y.push_back(kNone);
  }
  plot.series.push_back(std::move(horizon));
  return plot;
}

/// One row a satellite: in how many epochs, how its range went with the others'.
eval::Table satellite_table(const SppRun& run) {
  struct Row {
    std::size_t seen = 0, used = 0;
    std::vector<double> residuals, cn0;
  };
  std::map<SatelliteId, Row> rows;
  for (const SinglePoint& p : run.points) {
    for (const SatelliteResidual& r : p.residuals) {
      Row& row = rows[r.satellite];
      ++row.seen;
      row.used += r.range_used ? 1 : 0;
      if (r.range_used) row.residuals.push_back(r.range_m);
      if (std::isfinite(r.cn0_dbhz)) row.cn0.push_back(r.cn0_dbhz);
    }
  }
  eval::Table table({{"satellite"},
                     {"epochs"},
                     {"used", "%"},
                     {"mean residual", "m"},
                     {"RMS residual", "m"},
                     {"C/N0", "dB-Hz"}});
  for (const auto& [satellite, row] : rows) {
    const eval::Summary r = eval::summarise(row.residuals);
    table.add_row(
        {to_string(satellite), std::to_string(row.seen),
         eval::fixed(100.0 * static_cast<double>(row.used) / static_cast<double>(row.seen), 0),
         eval::fixed(r.mean, 2), eval::fixed(r.rmse, 2),
         eval::fixed(eval::summarise(row.cn0).mean, 1)});
  }
  return table;
}

io::Report report_of(const SppRun& run) {
  io::Report report(run.title);
  report.facts(run.facts);
  const std::vector<PositionError> errors = errors_of(run);
  if (!errors.empty()) report.heading("Errors against the reference").table(error_table(run));
  report.heading("Track").plot(track_plot(run));
  if (!errors.empty()) {
    report.heading("Errors");
    for (int axis = 0; axis < 3; ++axis) report.plot(errors_plot(run, errors, axis));
  }
  report.heading("Satellites").plot(satellites_plot(run)).plot(sky_plot(run));
  report.table(satellite_table(run), "Residuals are of the ranges used.");
  report.heading("Residuals").plot(residuals_plot(run));
  return report;
}

io::Trajectory3 track_of(const SppRun& run) {
  io::Trajectory3 track;
  const Geodetic origin = run.points.front().position;
  for (const SinglePoint& p : run.points) {
    const Eigen::Vector3d ned = ned_from_geodetic(p.position, origin);
    track.push_back({p.instant, Transform3<frame::Map, frame::Base>(
                                    SE3d({ned.y(), ned.x(), -ned.z()}, SO3d()))});
  }
  return track;
}

constexpr const char* kNames[] = {"positions.txt", "ranges.txt", "track.tum", "report.html"};

}  // namespace

std::vector<PositionError> errors_of(const SppRun& run) {
  std::vector<PositionError> errors;
  for (const SinglePoint& p : run.points) {
    const std::optional<NavState> truth = reference_at(run.truth, p.instant);
    if (!truth) continue;
    PositionError e;
    e.time = p.instant;
    e.ned_m = ned_from_geodetic(p.position, truth->position);
    e.sigma_m = p.position_covariance_ned_m2.diagonal().cwiseSqrt();
    if (run.truth_has_velocity && p.velocity_ned_mps)
      e.velocity_ned_mps = *p.velocity_ned_mps - truth->velocity_ned_mps;
    errors.push_back(e);
  }
  return errors;
}

eval::Table error_table(const SppRun& run) {
  eval::Table table({{""},
                     {"epochs"},
                     {"horizontal RMS", "m"},
                     {"median", "m"},
                     {"95 %", "m"},
                     {"largest", "m"},
                     {"vertical RMS", "m"},
                     {"velocity RMS", "m/s"}});
  Errors all, shared, peer;
  std::set<std::int64_t> peers;
  for (const GnssFix& fix : run.peer) {
    const std::optional<NavState> truth = reference_at(run.truth, fix.time);
    if (!truth) continue;
    peers.insert(second_of(fix.time));
    take({fix.time, ned_from_geodetic(fix.position, truth->position), {}, {}}, peer);
  }
  for (const PositionError& e : errors_of(run)) {
    take(e, all);
    if (peers.count(second_of(e.time)) != 0) take(e, shared);
  }
  add_row(table, "answered", all);
  if (run.peer.empty()) return table;
  add_row(table, "where the peer answers", shared);
  add_row(table, "the peer", peer);
  return table;
}

Result<void> prepare_spp_folder(const std::string& folder, const io::WriteOptions& options) {
  std::error_code code;
  fs::create_directories(folder, code);
  if (code) return Error{ErrorCode::io, "the folder cannot be made: " + code.message(), folder};
  for (const char* name : kNames) {
    const fs::path file = fs::path(folder) / name;
    if (options.existing == io::Existing::replace || !fs::exists(file, code)) continue;
    return Error{ErrorCode::io, "is there already; --force overwrites it", file.string()};
  }
  return {};
}

Result<std::string> write_spp_outputs(const std::string& folder, const SppRun& run,
                                      const io::WriteOptions& options) {
  const auto path = [&](const char* name) { return (fs::path(folder) / name).string(); };
  std::vector<GnssFix> fixes;
  for (const SinglePoint& p : run.points) fixes.push_back(to_fix(p));
  const Result<void> written[] = {io::write_fixes(path("positions.txt"), fixes, options),
                                  io::write_ranges(path("ranges.txt"), run.ranges, options),
                                  io::write_tum(path("track.tum"), track_of(run), options),
                                  report_of(run).write(path("report.html"), options)};
  for (const Result<void>& result : written)
    if (!result) return result.error();
  return path("report.html");
}

}  // namespace wayfare::examples
