#include "outputs.hpp"

#include <cmath>
#include <filesystem>
#include <map>
#include <system_error>

#include <wayfare/core/statistics.hpp>
#include <wayfare/gnss/signal.hpp>
#include <wayfare/io/nav_text.hpp>
#include <wayfare/io/tum.hpp>

#include "plots.hpp"

namespace wayfare::examples {
namespace {

namespace fs = std::filesystem;

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
