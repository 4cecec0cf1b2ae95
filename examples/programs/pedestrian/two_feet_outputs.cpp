// Table, picture and files of a walk with a unit on each foot.

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include <wayfare/eval/table.hpp>
#include <wayfare/io/report.hpp>

#include "two_feet.hpp"

namespace wayfare::examples {
namespace {

struct Track {
  std::string name;
  Trajectory poses;
};

std::array<Track, 6> tracks_of(const TwoFeetRun& run) {
  return {{{"left foot alone", io::planar(run.alone.left)},
           {"right foot alone", io::planar(run.alone.right)},
           {"midpoint, each alone", run.alone.middle},
           {"left foot, bound", io::planar(run.bound.left)},
           {"right foot, bound", io::planar(run.bound.right)},
           {"midpoint, bound", run.bound.middle}}};
}

Eigen::Vector2d at(const StampedPose& pose) { return pose.T_map_base.raw().translation(); }

eval::Table table_of(const TwoFeetRun& run) {
  eval::Table table({{"track"}, {"end from start", "m"}, {"farthest from start", "m"}});
  for (const Track& track : tracks_of(run)) {
    const Eigen::Vector2d start = at(track.poses.front());
    double farthest = 0.0;
    for (const StampedPose& p : track.poses) farthest = std::max(farthest, (at(p) - start).norm());
    table.add_row({track.name, eval::fixed((at(track.poses.back()) - start).norm(), 2),
                   eval::fixed(farthest, 2)});
  }
  return table;
}

/// The midpoint with the bound is the last.
std::vector<eval::Evaluated> errors_of(const TwoFeetRun& run, const Truth& truth) {
  const auto tracks = tracks_of(run);
  std::vector<NamedTrajectory> all;
  for (const Track& t : tracks) all.push_back({t.name, t.poses});
  return compare(truth, all);
}

/// Distances of the feet at the left one's poses.
std::vector<double> distances(const FeetTracks& tracks) {
  std::vector<double> result;
  auto right = tracks.right.begin();
  for (const io::StampedPose3& left : tracks.left) {
    while (right + 1 < tracks.right.end() && (right + 1)->time <= left.time) ++right;
    result.push_back(
        (right->T_map_base.raw().translation() - left.T_map_base.raw().translation()).norm());
  }
  return result;
}

double largest_distance(const FeetTracks& tracks) {
  const auto all = distances(tracks);
  return *std::max_element(all.begin(), all.end());
}

Facts facts_of(const TwoFeetRun& run) {
  const TwoFeetParameters& p = run.parameters;
  return {
      {"stances", std::to_string(run.bound.left_stances) + " left, " +
                      std::to_string(run.bound.right_stances) + " right"},
      {"right unit", eval::fixed(p.right_from_left.degrees(), 1) + " deg from the left one, " +
                         (run.heading_known ? "given" : "from the tracks")},
      {"bound", eval::fixed(p.farthest_m, 2) + " m, " + std::to_string(run.bound.projections) +
                    " projections"},
      {"farthest apart", eval::fixed(largest_distance(run.alone), 2) + " m alone, " +
                             eval::fixed(largest_distance(run.bound), 2) + " m with the bound"}};
}

io::Plot path_plot(const TwoFeetRun& run, const Truth& truth,
                   const std::vector<eval::Evaluated>& errors) {
  io::Plot plot = io::top_view("paths of the feet");
  for (const Track& t : tracks_of(run)) {
    const bool bound = t.name.ends_with("bound");
    if (!bound && t.name.starts_with("midpoint")) continue;
    plot.series.push_back(
        io::path_series(t.name, t.poses, {}, bound ? io::Mark::line : io::Mark::dashed));
  }
  if (!errors.empty()) plot.series.push_back(truth_series(truth, errors.back().errors));
  return plot;
}

io::Series over_time(const std::string& name, const io::Trajectory3& poses,
                     const std::vector<double>& values, LogTime start) {
  io::Series series{name, {}, {}};
  for (std::size_t i = 0; i < values.size(); ++i)
    series.add(to_seconds(poses[i].time - start), values[i]);
  return series;
}

io::Plot distance_plot(const TwoFeetRun& run) {
  io::Plot plot = io::time_plot("distance of the feet", "distance [m]");
  const LogTime start = run.bound.left.front().time;
  plot.series = {over_time("bound", run.bound.left, distances(run.bound), start),
                 over_time("each alone", run.alone.left, distances(run.alone), start)};
  const double end_s = to_seconds(run.bound.left.back().time - start);
  const double limit = run.parameters.farthest_m;
  plot.series.push_back({"limit", {0.0, end_s}, {limit, limit}, io::Mark::dashed});
  return plot;
}

io::Plot height_plot(const TwoFeetRun& run) {
  io::Plot plot = io::time_plot("heights", "z [m]");
  const LogTime start = run.bound.left.front().time;
  const auto add = [&](const char* name, const io::Trajectory3& poses) {
    std::vector<double> heights;
    for (const auto& p : poses) heights.push_back(p.T_map_base.raw().translation().z());
    plot.series.push_back(over_time(name, poses, heights, start));
  };
  add("left", run.bound.left);
  add("right", run.bound.right);
  return plot;
}

}  // namespace

std::string two_feet_text(const TwoFeetRun& run, const Truth& truth) {
  const std::string errors = to_text(error_tables(truth, errors_of(run, truth)));
  return to_text(facts_of(run)) + table_of(run).to_text() + errors + (errors.empty() ? "" : "\n");
}

Result<void> write_two_feet(const OutputArguments& to, const std::string& title,
                            const TwoFeetRun& run, const Truth& truth) {
  const std::vector<eval::Evaluated> errors = errors_of(run, truth);
  io::Report report(title, "dead reckoning by a unit on each foot");
  report.facts(facts_of(run)).table(table_of(run), "Tracks");
  for (const auto& [title_of_table, table] : error_tables(truth, errors))
    report.table(table, title_of_table);
  report.plot(path_plot(run, truth, errors)).plot(distance_plot(run)).plot(height_plot(run));
  for (const io::Plot& plot : distance_plots(truth, errors)) report.plot(plot);
  return first_error({io::write_tum(to.path("left.tum"), run.bound.left, to.write()),
                      io::write_tum(to.path("right.tum"), run.bound.right, to.write()),
                      io::write_tum(to.path("trajectory.tum"), run.bound.middle, to.write()),
                      to.write_report(report)});
}

}  // namespace wayfare::examples
