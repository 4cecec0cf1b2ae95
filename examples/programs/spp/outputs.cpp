#include "outputs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include <wayfare/core/statistics.hpp>
#include <wayfare/gnss/ephemerides.hpp>
#include <wayfare/io/nav_text.hpp>
#include <wayfare/io/report.hpp>
#include <wayfare/io/tum.hpp>

namespace wayfare::examples {
namespace {

/// Against the reference, interpolated between states at most 2 s apart; north, east, down.
struct PositionError {
  LogTime time;
  Eigen::Vector3d ned_m = Eigen::Vector3d::Zero();
  std::optional<Eigen::Vector3d> velocity_ned_mps;
  Eigen::Vector3d sigma_m = Eigen::Vector3d::Zero();
  bool consistent = true;
  double horizontal_protection_m = 0.0, vertical_protection_m = 0.0;
};

/// The reference, interpolated linearly.
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

void add(const PositionError& e, Errors& errors) {
  errors.horizontal.push_back(e.ned_m.head<2>().norm());
  errors.vertical.push_back(std::abs(e.ned_m.z()));
  if (e.velocity_ned_mps) errors.speed.push_back(e.velocity_ned_mps->norm());
}

void add_row(eval::Table& table, const std::string& name, const Errors& e, bool with_speed) {
  const Summary h = summarise(e.horizontal), v = summarise(e.vertical);
  std::vector<std::string> row = {name,
                                  std::to_string(h.count),
                                  eval::fixed(h.rmse, 3),
                                  eval::fixed(h.median, 3),
                                  eval::fixed(quantile(e.horizontal, 0.95), 2),
                                  eval::fixed(h.max, 2),
                                  eval::fixed(v.rmse, 3)};
  if (with_speed) row.push_back(eval::fixed(summarise(e.speed).rmse, 3));
  table.add_row(std::move(row));
}

/// Rounded to seconds, for epochs of the peer: receivers' clocks differ by milliseconds.
std::int64_t second_of(LogTime t) { return (t.nanoseconds() + 500'000'000) / 1'000'000'000; }

std::vector<PositionError> errors_of(const SppRun& run) {
  std::vector<PositionError> errors;
  for (const SinglePoint& p : run.points) {
    const std::optional<NavState> truth = reference_at(run.truth, p.instant);
    if (!truth) continue;
    PositionError e;
    e.time = p.instant;
    e.ned_m = ned_from_geodetic(p.position, truth->position);
    e.sigma_m = p.position_covariance_ned_m2.diagonal().cwiseSqrt();
    e.consistent = p.consistent;
    e.horizontal_protection_m = p.horizontal_protection_m;
    e.vertical_protection_m = p.vertical_protection_m;
    if (run.truth_has_velocity && p.velocity_ned_mps)
      e.velocity_ned_mps = *p.velocity_ned_mps - truth->velocity_ned_mps;
    errors.push_back(e);
  }
  return errors;
}

/// One row per satellite.
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
    const Summary r = summarise(row.residuals);
    table.add_row(
        {to_string(satellite), std::to_string(row.seen),
         eval::fixed(100.0 * static_cast<double>(row.used) / static_cast<double>(row.seen), 0),
         eval::fixed(r.mean, 2), eval::fixed(r.rmse, 2), eval::fixed(summarise(row.cn0).mean, 1)});
  }
  return table;
}

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

LogTime start_of(const SppRun& run) { return run.points.front().instant; }
double since_start(const SppRun& run, LogTime t) { return to_seconds(t - start_of(run)); }

io::Plot track_plot(const SppRun& run) {
  const Geodetic origin = run.points.front().position;
  io::Plot plot{"Track", "east [m]", "north [m]", {}, true};
  io::Series track{"single points", {}, {}, io::Mark::points};
  for (const SinglePoint& p : run.points) {
    const Eigen::Vector3d ned = ned_from_geodetic(p.position, origin);
    track.add(ned.y(), ned.x());
  }
  plot.series.push_back(std::move(track));
  if (run.truth.empty()) return plot;
  io::Series truth{"reference", {}, {}, io::Mark::line};
  for (const NavState& s : run.truth) {
    const bool during = s.time >= start_of(run) && s.time <= run.points.back().instant;
    const Eigen::Vector3d ned = ned_from_geodetic(s.position, origin);
    truth.add(during ? ned.y() : kNone, during ? ned.x() : kNone);
  }
  plot.series.push_back(std::move(truth));
  return plot;
}

/// `axis`: north, east, down. `errors` must not be empty.
io::Plot errors_plot(const SppRun& run, const std::vector<PositionError>& errors, int axis) {
  constexpr const char* kAxes[] = {"North", "East", "Down"};
  io::Plot plot = io::time_plot(std::string(kAxes[axis]) + " error and its 3σ bounds", "error [m]");
  io::Series error{"error", {}, {}}, upper{"±3σ", {}, {}};
  LogTime last = errors.front().time;
  for (const PositionError& e : errors) {
    const double t = since_start(run, e.time);
    if (e.time - last > std::chrono::seconds(3)) {
      error.add(since_start(run, last), kNone);
      upper.add(since_start(run, last), kNone);
    }
    error.add(t, e.ned_m[axis]);
    upper.add(t, 3.0 * e.sigma_m[axis]);
    last = e.time;
  }
  plot.series = {std::move(error), io::bounds_series(upper)};
  return plot;
}

io::Plot satellites_plot(const SppRun& run) {
  io::Plot plot = io::time_plot("Satellites", "number");
  io::Series seen{"with a range", {}, {}, io::Mark::points}, used{"used", {}, {}, io::Mark::points};
  for (const SinglePoint& p : run.points) {
    const auto measured = std::count_if(p.residuals.begin(), p.residuals.end(),
                                        [](const auto& r) { return std::isfinite(r.range_m); });
    seen.add(since_start(run, p.instant), static_cast<double>(measured));
    used.add(since_start(run, p.instant), p.used);
  }
  plot.series = {std::move(seen), std::move(used)};
  return plot;
}

io::Plot residuals_plot(const SppRun& run) {
  io::Plot plot = io::time_plot("Range residuals in standard deviations", "residual / σ");
  io::Series used{"used", {}, {}, io::Mark::points}, out{"left out", {}, {}, io::Mark::points};
  for (const SinglePoint& p : run.points) {
    for (const SatelliteResidual& r : p.residuals) {
      if (!std::isfinite(r.range_m)) continue;
      (r.range_used ? used : out)
          .add(since_start(run, p.instant), std::clamp(r.range_m / r.range_sigma_m, -30.0, 30.0));
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
      s.add(zenith * std::sin(r.sight.azimuth_rad), zenith * std::cos(r.sight.azimuth_rad));
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
      horizon.add(zenith * std::sin(a), zenith * std::cos(a));
    }
    horizon.add(kNone, kNone);
  }
  plot.series.push_back(std::move(horizon));
  return plot;
}

io::Report report_of(const SppRun& run) {
  io::Report report(run.title);
  report.facts(run.facts);
  const std::vector<PositionError> errors = errors_of(run);
  if (!errors.empty())
    report.heading("Errors against the reference").table(error_table(run)).table(bounds_table(run));
  report.heading("Track").plot(track_plot(run));
  if (!errors.empty()) {
    report.heading("Errors");
    for (int axis = 0; axis < 3; ++axis) report.plot(errors_plot(run, errors, axis));
  }
  report.heading("Satellites").plot(satellites_plot(run)).plot(sky_plot(run));
  report.table(satellite_table(run), "Residuals of the ranges used.");
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

}  // namespace

eval::Table error_table(const SppRun& run) {
  std::vector<eval::Table::Column> columns = {
      {""},          {"epochs"},       {"horizontal RMS", "m"}, {"median", "m"},
      {"95 %", "m"}, {"largest", "m"}, {"vertical RMS", "m"}};
  const bool speed = run.truth_has_velocity;
  if (speed) columns.push_back({"velocity RMS", "m/s"});
  eval::Table table(columns);
  Errors all, shared, peer;
  std::set<std::int64_t> peers;
  for (const GnssFix& fix : run.peer) {
    const std::optional<NavState> truth = reference_at(run.truth, fix.time);
    if (!truth) continue;
    peers.insert(second_of(fix.time));
    add({fix.time, ned_from_geodetic(fix.position, truth->position), {}, {}, true, 0.0, 0.0}, peer);
  }
  for (const PositionError& e : errors_of(run)) {
    add(e, all);
    if (peers.contains(second_of(e.time))) add(e, shared);
  }
  add_row(table, "answered", all, speed);
  if (run.peer.empty()) return table;
  add_row(table, "at the peer's epochs", shared, speed);
  add_row(table, "peer", peer, speed);
  return table;
}

eval::Table bounds_table(const SppRun& run) {
  eval::Table table({{""},
                     {"epochs"},
                     {"horizontal RMS", "m"},
                     {"largest", "m"},
                     {"north within 3\u03c3", "%"},
                     {"east", "%"},
                     {"down", "%"},
                     {"horizontal within protection level", "%"},
                     {"vertical", "%"}});
  const std::vector<PositionError> errors = errors_of(run);
  const auto add_row_of = [&](const char* name, const auto& wanted) {
    std::vector<double> horizontal;
    std::array<std::size_t, 5> inside{};
    for (const PositionError& e : errors) {
      if (!wanted(e)) continue;
      horizontal.push_back(e.ned_m.head<2>().norm());
      for (std::size_t k = 0; k < 3; ++k) {
        const auto i = static_cast<Eigen::Index>(k);
        inside[k] += std::abs(e.ned_m[i]) <= 3.0 * e.sigma_m[i] ? 1 : 0;
      }
      inside[3] += horizontal.back() <= e.horizontal_protection_m ? 1 : 0;
      inside[4] += std::abs(e.ned_m.z()) <= e.vertical_protection_m ? 1 : 0;
    }
    if (horizontal.empty()) return;
    const auto count = static_cast<double>(horizontal.size());
    std::vector<std::string> row = {name, std::to_string(horizontal.size()),
                                    eval::fixed(summarise(horizontal).rmse, 3),
                                    eval::fixed(summarise(horizontal).max, 2)};
    for (const std::size_t n : inside)
      row.push_back(eval::fixed(100.0 * static_cast<double>(n) / count, 1));
    table.add_row(std::move(row));
  };
  add_row_of("all", [](const PositionError&) { return true; });
  add_row_of("consistent", [](const PositionError& e) { return e.consistent; });
  add_row_of("not consistent", [](const PositionError& e) { return !e.consistent; });
  return table;
}

Result<void> write_spp_outputs(const OutputArguments& to, const TrackFormats& formats,
                               const SppRun& run) {
  if (to.out.empty()) return to.write_report(report_of(run));
  std::vector<GnssFix> fixes;
  for (const SinglePoint& p : run.points) fixes.push_back(to_fix(p));
  return first_error({io::write_fixes(to.path("positions.txt"), fixes, to.write()),
                      io::write_ranges(to.path("ranges.txt"), run.ranges, to.write()),
                      io::write_tum(to.path("track.tum"), track_of(run), to.write()),
                      write_track_files(to, formats, fixes), to.write_report(report_of(run))});
}

}  // namespace wayfare::examples
