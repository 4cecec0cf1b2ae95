#include "plots.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include <wayfare/gnss/ephemerides.hpp>
#include <wayfare/io/report.hpp>

namespace wayfare::examples {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

LogTime start_of(const SppRun& run) { return run.points.front().instant; }
double since_start(const SppRun& run, LogTime t) { return to_seconds(t - start_of(run)); }

}  // namespace

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

}  // namespace wayfare::examples
