// Single-point positioning from RINEX observations and navigation messages.

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/gnss/ephemerides.hpp>
#include <wayfare/gnss/gps_time.hpp>
#include <wayfare/gnss/single_point.hpp>
#include <wayfare/io/nav_text.hpp>
#include <wayfare/io/observations.hpp>
#include <wayfare/io/rinex.hpp>

#include "outputs.hpp"
#include "support/progress_line.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

struct Arguments : OutputArguments {
  std::string obs, truth, truth_columns, peer, systems = "GREC";
  std::vector<std::string> nav;
  TrackFormats formats;
  std::size_t truth_skip = 0;
  double truth_shift_s = 0.0, elevation_mask_deg = 10.0, min_cn0 = 0.0;
  bool no_ionosphere = false, no_troposphere = false, no_exclusion = false, no_offsets = false;
  bool only_consistent = false, reflections = false;
  double alert_limit_m = 40.0;
};

Result<std::array<bool, kGnssSystems>> systems_of(const std::string& letters) {
  std::array<bool, kGnssSystems> wanted{};
  for (const char letter : letters) {
    if (letter == ',') continue;
    const auto system = system_of(letter);
    if (!system)
      return bad_use(std::string("--system: no system has the letter '") + letter +
                     "'; there are G, R, E, C");
    wanted[static_cast<std::size_t>(index_of(*system))] = true;
  }
  return wanted;
}

/// Of the files, and those received with the observations.
Result<Ephemerides> read_messages(const std::vector<std::string>& paths,
                                  const Ephemerides& received) {
  Ephemerides all;
  for (const std::string& path : paths) {
    const auto nav = io::read_rinex_navigation(path);
    if (!nav) return nav.error();
    print_problems(nav->problems);
    all.add(nav->ephemerides);
  }
  all.add(received);
  if (all.empty() && paths.empty())
    return bad_use("--nav is needed: --obs contains no navigation message that can be used");
  if (all.empty())
    return Error{ErrorCode::not_found, "no navigation message could be used", "--nav"};
  return all;
}

io::ColumnFormat truth_format(const Arguments& a) {
  io::ColumnFormat format;
  std::istringstream names(a.truth_columns);
  for (std::string name; std::getline(names, name, ',');) format.columns.push_back(name);
  format.skip_lines = a.truth_skip;
  return format;
}

Result<void> read_reference(const Arguments& a, SppRun& run) {
  if (!a.truth.empty()) {
    auto truth = io::read_nav(a.truth, truth_format(a));
    if (!truth) return truth.error();
    print_problems(truth->problems);
    run.truth = std::move(truth->trajectory);
    for (NavState& state : run.truth) state.time += from_seconds(a.truth_shift_s);
    run.truth_has_velocity = truth->has_velocity;
  }
  if (!a.peer.empty()) {
    auto peer = io::read_fixes(a.peer);
    if (!peer) return peer.error();
    print_problems(peer->problems);
    run.peer = std::move(peer->fixes);
  }
  return {};
}

SinglePointOptions options_of(const Arguments& a, const std::array<bool, kGnssSystems>& systems) {
  SinglePointOptions options;
  options.corrections.systems = systems;
  options.corrections.elevation_mask = Angle::degrees(a.elevation_mask_deg);
  options.corrections.min_cn0_dbhz = a.min_cn0;
  options.corrections.ionosphere = !a.no_ionosphere;
  options.corrections.troposphere = !a.no_troposphere;
  options.exclude_faults = !a.no_exclusion;
  options.answer_inconsistent = !a.only_consistent;
  options.alert_limit_m = a.alert_limit_m;
  return options;
}

/// Why epochs have no position and satellites are not used.
struct Refusals {
  std::map<std::string, std::size_t> epochs, satellites;
  std::set<SatelliteId> without_message;
};

void note(const std::vector<RefusedRange>& refused, Refusals& refusals) {
  for (const RefusedRange& r : refused) {
    ++refusals.satellites[to_text(r.why)];
    if (r.why == RangeRefusal::no_ephemeris) refusals.without_message.insert(r.satellite);
  }
}

/// Epoch by epoch; the systems' clock offsets are estimated over epochs. Returns the time taken, s.
double solve(const io::RawObservations& obs, const Ephemerides& messages,
             SinglePointOptions options, const Arguments& a, SppRun& run, Refusals& refusals) {
  ProgressLine progress("single points", a.quiet);
  SystemOffsets offsets;
  Eigen::Vector3d near = Eigen::Vector3d::Zero();
  for (const ObservationEpoch& epoch : obs.epochs) {
    progress.update(static_cast<double>(run.epochs++) / static_cast<double>(obs.epochs.size()));
    options.offsets = {};
    options.reflections.reset();
    auto point = single_point(epoch, messages, options, near);
    if (point) offsets.learn(*point);
    options.offsets = offsets.all();
    if (a.no_offsets) options.offsets = {};
    if (a.reflections) options.reflections.emplace();
    if (!a.no_offsets || a.reflections) point = single_point(epoch, messages, options, near);
    if (!point) {
      const std::string& why = point.error().message;
      ++refusals.epochs[why.substr(0, why.find_first_of("(:"))];
      continue;
    }
    note(point->refused, refusals);
    near = point->position_ecef_m;
    run.ranges.push_back(correct_ranges(epoch, messages, near, options.corrections));
    run.ranges.back().time = point->instant;
    run.points.push_back(*std::move(point));
  }
  for (RangeEpoch& ranges : run.ranges) ranges = on_one_clock(ranges, offsets);
  return progress.finish();
}

void print_refusals(const Refusals& refusals) {
  for (const auto& [why, count] : refusals.epochs)
    std::printf("no position    %zu epoch%s: %s\n", count, count == 1 ? "" : "s", why.c_str());
  for (const auto& [why, count] : refusals.satellites)
    std::printf("not used       %zu observations: %s\n", count, why.c_str());
  std::string names;
  for (const SatelliteId s : refusals.without_message) names.append(" ").append(to_string(s));
  if (!names.empty()) std::printf("no message for%s\n", names.c_str());
}

Facts facts_of(const SppRun& run, const Ephemerides& messages, const Arguments& a, double took_s) {
  const auto consistent = std::count_if(run.points.begin(), run.points.end(),
                                        [](const SinglePoint& p) { return p.consistent; });
  return {
      {"epochs", std::to_string(run.epochs)},
      {"answered", std::to_string(run.points.size()) + ", " + std::to_string(consistent) +
                       " of them consistent"},
      {"messages", std::to_string(messages.size()) + " of " +
                       std::to_string(messages.satellites().size()) + " satellites"},
      {"ionosphere", a.no_ionosphere              ? "not corrected"
                     : messages.gps_ionosphere    ? "Klobuchar, GPS message"
                     : messages.beidou_ionosphere ? "Klobuchar, BeiDou message"
                                                  : "nominal: no message has coefficients"},
      {"took", eval::fixed(1e6 * took_s / static_cast<double>(run.epochs), 0) + " µs per epoch"}};
}

Result<Doubt> run_spp(const Arguments& a) {
  if (auto ready = a.prepare(
          a.formats.with_files({"positions.txt", "ranges.txt", "track.tum", "report.html"}));
      !ready)
    return ready.error();
  const auto systems = systems_of(a.systems);
  if (!systems) return systems.error();
  const auto obs = io::read_observations(a.obs);
  if (!obs) return obs.error();
  print_problems(obs->problems);
  const Result<Ephemerides> messages = read_messages(a.nav, obs->ephemerides);
  if (!messages) return messages.error();
  SppRun run;
  run.title = "Single points of " + std::filesystem::path(a.obs).filename().string();
  if (const auto read = read_reference(a, run); !read) return read.error();

  Refusals refusals;
  const double took_s = solve(*obs, *messages, options_of(a, *systems), a, run, refusals);
  if (!a.quiet) print_refusals(refusals);
  if (run.points.empty()) {
    const std::string why =
        refusals.epochs.empty() ? "there are no epochs" : refusals.epochs.begin()->first;
    return Error{ErrorCode::degenerate, "no epoch gives a position: " + why, a.obs};
  }
  run.facts = facts_of(run, *messages, a, took_s);
  if (a.wants_report())
    if (auto done = write_spp_outputs(a, a.formats, run); !done) return done.error();
  if (!a.out.empty()) run.facts.emplace_back("report", a.path("report.html"));
  if (!a.quiet) std::fputs(to_text(run.facts).c_str(), stdout);
  if (!a.quiet && !run.truth.empty())
    std::printf("\n%s\n%s", error_table(run).to_text().c_str(),
                bounds_table(run).to_text().c_str());
  const bool any = std::ranges::any_of(run.points, &SinglePoint::consistent);
  return Doubt{any ? "" : "no position is of consistent ranges"};
}

void add_options(CommandLine& app, Arguments& a) {
  app.add_file("--obs", a.obs,
               "observations: RINEX 2 or 3, or UBX (RXM-RAWX, RXM-SFRBX), plain or gzip")
      .required();
  app.add_file("--nav", a.nav, "RINEX navigation files; not needed where UBX has those of GPS");
  app.add_option("--system", a.systems, "systems to use: G GPS, R GLONASS, E Galileo, C BeiDou")
      .show_default();
  app.add_option(
         "--out", a.out,
         "folder for positions.txt, ranges.txt, track.tum and report.html, created if needed")
      .shown_as("DIR");
  app.add_file(
      "--truth", a.truth,
      "reference positions of the antenna: named columns, RTKLIB's .pos, GPX, NMEA or UBX");
  app.add_option("--truth-columns", a.truth_columns,
                 "comma-separated names of its columns, if it has none: "
                 "week,tow_s,lat_deg,lon_deg,h_m");
  app.add_option("--truth-skip", a.truth_skip, "lines before its data").show_default();
  app.add_option("--truth-shift", a.truth_shift_s, "seconds added to its times").show_default();
  app.add_file("--peer", a.peer,
               "another program's solution (RTKLIB's .pos, GPX, NMEA or UBX), to compare with")
      .needs("--truth");
  app.add_number("--elevation-mask", a.elevation_mask_deg, 0.0, 90.0,
                 "smallest elevation of the satellites used, deg");
  app.add_option("--min-cn0", a.min_cn0, "smallest C/N0 of the signals used, dB-Hz").show_default();
  app.add_flag("--no-ionosphere", a.no_ionosphere, "do not correct for the ionosphere");
  app.add_flag("--no-troposphere", a.no_troposphere, "do not correct for the troposphere");
  app.add_flag("--no-exclusion", a.no_exclusion, "plain least squares without fault exclusion");
  app.add_flag("--no-offsets", a.no_offsets,
               "estimate the clock of every system in every epoch, independent of earlier ones");
  app.add_flag("--reflections", a.reflections,
               "for cities: ranges may be reflected, and then longer, the more probably the weaker "
               "they are");
  app.add_number("--alert-limit", a.alert_limit_m, 0.0, 1e6,
                 "horizontal protection level up to which a position by --reflections is "
                 "consistent, m");
  app.add_flag("--only-consistent", a.only_consistent, "no position from inconsistent ranges");
  a.formats.add_option(app);
  add_force_and_quiet(app, a);
  add_json(app, a);
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine app(
      "Position, velocity and time from each epoch of a receiver's code and Doppler measurements "
      "with broadcast orbits and clocks and exclusion of faulty satellites. One frequency, without "
      "carrier phase and differential corrections: accurate to metres, not centimetres.");
  Arguments arguments;
  add_options(app, arguments);
  app.example("--obs rover.obs --nav brdc.nav", "positions of a receiver, counts only");
  app.example("--obs rover.ubx --track-formats kml,gpx --out points",
              "of a u-blox stream, with the track for other programs");
  app.example("--obs rover.obs --nav brdc.nav --truth reference.pos --out points",
              "with errors, positions and a report");
  if (const auto code = app.parse(argc, argv)) return *code;
  return exit_code("spp", run_spp(arguments));
}
