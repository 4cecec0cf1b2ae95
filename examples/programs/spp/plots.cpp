#include "plots.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include <wayfare/gnss/signal.hpp>

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
  io::Series error{"error", {}, {}};
  io::Series bounds[] = {{"±3σ", {}, {}, io::Mark::dashed}, {"", {}, {}, io::Mark::dashed}};
  const auto add = [&run](io::Series& s, LogTime t, double y) {
    s.x.push_back(since_start(run, t));
    s.y.push_back(y);
  };
  LogTime last = errors.front().time;
  for (const PositionError& e : errors) {
    const bool gap = e.time - last > std::chrono::seconds(3);
    for (const auto& [series, y] :
         {std::pair(&error, e.ned_m[axis]), std::pair(&bounds[0], 3.0 * e.sigma_m[axis]),
          std::pair(&bounds[1], -3.0 * e.sigma_m[axis])}) {
      if (gap) add(*series, last, kNone);
      add(*series, e.time, y);
    }
    last = e.time;
  }
  // One series, so that both bounds look the same.
  add(bounds[0], last, kNone);
  bounds[0].x.insert(bounds[0].x.end(), bounds[1].x.begin(), bounds[1].x.end());
  bounds[0].y.insert(bounds[0].y.end(), bounds[1].y.begin(), bounds[1].y.end());
  plot.series = {std::move(error), std::move(bounds[0])};
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

}  // namespace wayfare::examples
