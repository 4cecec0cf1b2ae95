// Two tracks of one drive compared.

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/core/se3.hpp>

#include "outputs.hpp"
#include "track_file.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

struct Arguments : OutputArguments {
  std::string first, second, align = "none";
  std::vector<std::string> columns;
  std::size_t skip_first = 0, skip_second = 0;
  eval::TrackComparisonOptions options;
};

/// "A:NAME=COLUMN", "B:NAME=COLUMN".
Result<void> choose(const Arguments& a, io::ColumnFormat& first, io::ColumnFormat& second) {
  for (const std::string& text : a.columns) {
    const std::size_t equal = text.find('=');
    const bool good = (text.starts_with("A:") || text.starts_with("B:")) && equal != text.npos &&
                      equal > 2 && equal + 1 < text.size();
    if (!good)
      return bad_use("--column must be A:NAME=COLUMN or B:NAME=COLUMN, not '" + text + "'");
    (text[0] == 'A' ? first : second)
        .choices.push_back({text.substr(2, equal - 2), text.substr(equal + 1)});
  }
  return {};
}

/// Angle between the vertical axes of both tracks, degrees.
double tilt_deg(const SE3d& alignment) {
  const double up = (alignment.rotation() * Eigen::Vector3d::UnitZ()).z();
  return std::acos(std::clamp(up, -1.0, 1.0)) * 180.0 / std::numbers::pi;
}

Facts facts_of(const TracksCompared& run, const TrackFile& a, const TrackFile& b,
               const eval::TrackComparisonOptions& options) {
  const eval::TrackComparison& c = run.comparison;
  Facts facts = {
      {"first", run.first + ", " + std::to_string(a.size()) + " points"},
      {"second", run.second + ", " + std::to_string(b.size()) + " points"},
      {"compared",
       std::to_string(c.differences.size()) + " points in " +
           eval::fixed(to_seconds(c.differences.back().time - c.differences.front().time), 1) +
           " s"},
      {"path", eval::fixed(c.path_m, 1) + " m"},
      {"time offset", eval::fixed(c.offset_s, options.search_s > 0.0 ? 4 : 3) + " s"}};
  if (!run.aligned) return facts;
  const Eigen::Vector3d t = c.alignment.translation();
  const Eigen::Vector3d ahead = c.alignment.rotation() * Eigen::Vector3d::UnitX();
  facts.emplace_back("moved by", eval::fixed(t.x(), 3) + ", " + eval::fixed(t.y(), 3) + ", " +
                                     eval::fixed(t.z(), 3) + " m");
  facts.emplace_back("turned by",
                     eval::fixed(std::atan2(ahead.y(), ahead.x()) * 180.0 / std::numbers::pi, 3) +
                         " deg about the vertical, tilted by " +
                         eval::fixed(tilt_deg(c.alignment), 3) + " deg");
  return facts;
}

Doubt doubt_of(const TracksCompared& run, double search_s) {
  const eval::TrackComparison& c = run.comparison;
  constexpr double kLargestTilt_deg = 30.0, kLeastSharpness_mps2 = 0.01;
  if (search_s > 0.0 && c.sharpness_mps2 < kLeastSharpness_mps2)
    return {"the tracks do not determine the time offset: they hardly move"};
  if (search_s > 0.0 && c.at_limit)
    return {"the best time offset is at the end of the search; --search-offset sets its range"};
  if (run.aligned && run.has_height && tilt_deg(c.alignment) > kLargestTilt_deg)
    return {"the alignment tilts the first track by " + eval::fixed(tilt_deg(c.alignment), 0) +
            " deg: an axis or its sign may be wrong"};
  return {};
}

Result<Doubt> run(const Arguments& a) {
  io::ColumnFormat first_format, second_format;
  first_format.skip_lines = a.skip_first, second_format.skip_lines = a.skip_second;
  if (auto chosen = choose(a, first_format, second_format); !chosen) return chosen.error();
  if (auto ready = a.prepare({"errors.csv", "errors.svg", "plan.svg", "report.html"}); !ready)
    return ready.error();
  const auto first = read_track(a.first, first_format);
  if (!first) return first.error();
  const auto second = read_track(a.second, second_format);
  if (!second) return second.error();
  if (first->is_geographic() != second->is_geographic() && a.align == "none")
    return bad_use(
        "one track is on the Earth and the other in local axes: --align rigid is needed");

  TracksCompared run;
  run.first = std::filesystem::path(a.first).filename().string();
  run.second = std::filesystem::path(a.second).filename().string();
  if (run.first == run.second) run.first = a.first, run.second = a.second;
  run.title = run.first + " against " + run.second;
  run.aligned = a.align == "rigid";
  run.has_height = first->has_height && second->has_height;
  const Geodetic origin = second->is_geographic()  ? second->geographic.front().position
                          : first->is_geographic() ? first->geographic.front().position
                                                   : Geodetic{};
  eval::Track moving = in_local_axes(*first, origin);
  run.reference = in_local_axes(*second, origin);
  if (!run.has_height)
    for (eval::Track* track : {&moving, &run.reference})
      for (eval::TrackPoint& p : *track) p.position_m.z() = 0.0;
  eval::TrackComparisonOptions options = a.options;
  options.rigid = run.aligned;
  auto comparison = eval::compare_tracks(moving, run.reference, options);
  if (!comparison) {
    Error error = comparison.error();
    for (const auto& [name, path] :
         {std::pair("the first track: ", a.first), {"the second track: ", a.second}})
      if (error.message.starts_with(name))
        error.message = error.message.substr(std::string(name).size()), error.source = path;
    return error;
  }
  run.comparison = *std::move(comparison);
  run.facts = facts_of(run, *first, *second, options);
  if (auto done = write_comparison(a, run); !done) return done.error();
  if (!a.quiet)
    std::printf("%s\n%s", to_text(run.facts).c_str(),
                eval::track_table(run.comparison, run.has_height).to_text().c_str());
  if (!a.quiet && !a.out.empty()) std::printf("report: %s\n", a.path("report.html").c_str());
  return doubt_of(run, options.search_s);
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine app(
      "Compare two tracks of one drive: errors of the first along and across the direction of "
      "motion of the second, and in height. Tracks are TUM text, columns of text (positions on the "
      "Earth, or t_s, x_m, y_m), RTKLIB's .pos, GPX, KML with times, NMEA or UBX (NAV-PVT), plain "
      "or "
      "gzip. A line that cannot be read, and times that do not increase, are errors.");
  Arguments a;
  app.add_file("A", a.first, "the track to judge").required();
  app.add_file("B", a.second, "the reference, interpolated at the times of A").required();
  app.add_option("--align", a.align,
                 "none, or rigid: move and turn A in space so that it fits B best")
      .one_of({"none", "rigid"})
      .show_default();
  app.add_option("--offset", a.options.offset_s, "seconds added to the times of A").show_default();
  app.add_number(
      "--search-offset", a.options.search_s, 0.0, 1e5,
      "search the offset that fits best within ± these seconds around --offset, whatever "
      "the constant difference");
  app.add_number("--max-gap", a.options.max_gap_s, 0.0, 1e6,
                 "B is not interpolated in longer gaps, s; 0: three times its usual interval, at "
                 "least 1.5 s");
  app.add_option("--column", a.columns,
                 "FILE:NAME=COLUMN, a column of a foreign file by heading or number: "
                 "A:lat_deg=\"Latitude\"; FILE is A or B")
      .take_all();
  app.add_option("--skip-a", a.skip_first, "lines before the header or data of A").show_default();
  app.add_option("--skip-b", a.skip_second, "lines before the header or data of B").show_default();
  app.add_option("--out", a.out, "folder for errors.csv, errors.svg, plan.svg and report.html")
      .shown_as("DIR");
  add_force_and_quiet(app, a);
  add_json(app, a);
  app.example("ins/trajectory.txt reference.pos --out compared", "a solution against a reference");
  app.example("phone.gpx reference.pos --search-offset 5",
              "a phone's track whose clock is a few seconds off");
  app.example("slam.tum ins/trajectory.tum --align rigid", "tracks in different axes");
  if (const auto code = app.parse(argc, argv)) return *code;
  return exit_code("compare_tracks", run(a));
}
