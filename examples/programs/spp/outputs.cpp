#include "outputs.hpp"

#include <cmath>
#include <map>

#include <wayfare/core/statistics.hpp>
#include <wayfare/gnss/ephemerides.hpp>
#include <wayfare/io/nav_text.hpp>
#include <wayfare/io/tum.hpp>

#include "plots.hpp"

namespace wayfare::examples {
namespace {

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

std::vector<std::string> spp_output_names() {
  return {"positions.txt", "ranges.txt", "track.tum", "report.html"};
}

Result<void> write_spp_outputs(const OutputArguments& to, const SppRun& run) {
  std::vector<GnssFix> fixes;
  for (const SinglePoint& p : run.points) fixes.push_back(to_fix(p));
  return first_error({io::write_fixes(to.path("positions.txt"), fixes, to.write()),
                      io::write_ranges(to.path("ranges.txt"), run.ranges, to.write()),
                      io::write_tum(to.path("track.tum"), track_of(run), to.write()),
                      report_of(run).write(to.path("report.html"), to.write())});
}

}  // namespace wayfare::examples
