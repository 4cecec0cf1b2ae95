#include "outputs.hpp"

#include <array>
#include <limits>
#include <utility>

#include <wayfare/core/statistics.hpp>
#include <wayfare/io/text_file.hpp>

namespace wayfare::examples {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// Calls `take(difference, seconds)`, and `gap(seconds)` where the first track is not compared for
/// more than five of its usual intervals.
template <class Take, class Gap>
void over_time(const eval::TrackComparison& c, const Take& take, const Gap& gap) {
  std::vector<double> times, intervals;
  for (const eval::TrackDifference& d : c.differences) {
    times.push_back(to_seconds(d.time - c.differences.front().time));
    if (times.size() > 1) intervals.push_back(times.back() - times[times.size() - 2]);
  }
  const double usual_s = upper_median_of(intervals);
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (i > 0 && times[i] - times[i - 1] > 5.0 * usual_s) gap(times[i]);
    take(c.differences[i], times[i]);
  }
}

io::Plot errors_plot(const TracksCompared& run) {
  io::Plot plot = io::time_plot("Errors of " + run.first, "error [m]");
  constexpr std::array kNames = {"along", "across, to the left", "up"};
  for (Eigen::Index axis = 0; axis < (run.has_height ? 3 : 2); ++axis) {
    io::Series series{kNames.at(static_cast<std::size_t>(axis)), {}, {}};
    over_time(
        run.comparison,
        [&](const eval::TrackDifference& d, double t) { series.add(t, d.error_m[axis]); },
        [&](double t) { series.add(t, kNone); });
    plot.series.push_back(std::move(series));
  }
  return plot;
}

io::Plot plan_plot(const TracksCompared& run) {
  io::Plot plot{"Plan", "east or x [m]", "north or y [m]", {}, true};
  io::Series second{run.second, {}, {}, io::Mark::dashed}, first{run.first, {}, {}};
  const LogTime begin = run.comparison.differences.front().time - std::chrono::seconds(1),
                end = run.comparison.differences.back().time + std::chrono::seconds(1);
  for (const eval::TrackPoint& p : run.reference)
    if (p.time >= begin && p.time <= end) second.add(p.position_m.x(), p.position_m.y());
  over_time(
      run.comparison,
      [&](const eval::TrackDifference& d, double) {
        first.add(d.position_m.x(), d.position_m.y());
      },
      [&](double) { first.add(kNone, kNone); });
  plot.series = {std::move(first), std::move(second)};
  return plot;
}

io::Plot search_plot(const TracksCompared& run) {
  return {"Search of the time offset",
          "offset [s]",
          "RMS distance without its mean, or aligned [m]",
          {{"distance", run.comparison.tried_s, run.comparison.tried_rms_m}}};
}

std::string csv_of(const TracksCompared& run) {
  std::string out =
      "t_s,along_m,left_m,up_m,x_m,y_m,z_m,reference_x_m,reference_y_m,reference_z_m\n";
  for (const eval::TrackDifference& d : run.comparison.differences) {
    out += io::format_nanoseconds(d.time.nanoseconds());
    for (const Eigen::Vector3d& v : {d.error_m, d.position_m, d.reference_m})
      for (const double component : v) out += ',' + eval::fixed(component, 4);
    out += '\n';
  }
  return out;
}

}  // namespace

Result<void> write_comparison(const OutputArguments& to, const TracksCompared& run) {
  if (!to.wants_report()) return {};
  io::Report report(run.title);
  report.facts(run.facts);
  report.heading("Errors").table(eval::track_table(run.comparison, run.has_height),
                                 "The first track less the second; along and across the second's "
                                 "direction of motion.");
  report.plot(errors_plot(run)).heading("Plan").plot(plan_plot(run));
  if (!run.comparison.tried_s.empty()) report.heading("Time offset").plot(search_plot(run));
  if (to.out.empty()) return to.write_report(report);
  return first_error(
      {io::write_file(to.path("errors.csv"), csv_of(run), to.write()),
       io::write_file(to.path("errors.svg"), io::to_svg_document(errors_plot(run)), to.write()),
       io::write_file(to.path("plan.svg"), io::to_svg_document(plan_plot(run)), to.write()),
       to.write_report(report)});
}

}  // namespace wayfare::examples
