// Drift of inertial navigation in satellite outages of 10 to 30 s with none to four satellites
// left, each at ten times of a drive.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/gnss/single_point.hpp>

#include "outage_results.hpp"
#include "support/nav_drives.hpp"
#include "support/nav_outputs.hpp"
#include "support/progress_line.hpp"
#include "support/ros_topics.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

struct Options : OutputArguments {
  NavFiles files;
  RangeSimulation ranges;
  std::string config;
  std::size_t places = 10;
  double first_s = 0.0;
  int threads = 1;
  bool simulated = false, smooth = false, wheels = false;
  double wheel_scale = 0.01;
  std::vector<double> left;
};

NavTrajectory antenna_track(const std::vector<GnssInsPoint>& points,
                            const GnssInsOptions& options) {
  NavTrajectory track;
  track.reserve(points.size());
  for (const GnssInsPoint& p : points)
    track.push_back(eval::at_lever_arm(p.nav, options.antenna_lever_arm_m));
  return track;
}

double horizontal(const Geodetic& a, const Geodetic& b) {
  return ned_from_geodetic(a, b).head<2>().norm();
}

/// Errors of the single-point positions, by time.
std::map<LogTime, double> plain_errors(const KnownDrive& drive) {
  std::map<LogTime, double> errors;
  Eigen::Vector3d near = Eigen::Vector3d::Zero();
  for (const RangeEpoch& epoch : drive.recording.ranges) {
    const auto point = single_point(epoch, {}, near);
    if (!point) continue;
    near = point->position_ecef_m;
    errors[epoch.time] = horizontal(point->position, drive.antenna_truth(epoch.time).position);
  }
  return errors;
}

/// Errors of filter and plain GNSS at epochs after the filter has settled, outside of the window.
std::vector<std::pair<double, double>> outside_of(const OutageWindow& window,
                                                  const NavTrajectory& track,
                                                  const std::map<LogTime, double>& plain,
                                                  const KnownDrive& drive) {
  std::vector<std::pair<double, double>> pairs;
  const LogTime settled = track.front().time + std::chrono::seconds(10);
  auto state = track.begin();
  for (const auto& [time, error] : plain) {
    while (state != track.end() && state->time < time) ++state;
    if (state == track.end()) break;
    if (time < settled || window.contains(time) ||
        state->time - time > std::chrono::milliseconds(30))
      continue;
    pairs.emplace_back(horizontal(state->position, drive.antenna_truth(state->time).position),
                       error);
  }
  return pairs;
}

Result<OutageVariant> run_variant(const std::string& name, const KnownDrive& drive,
                                  const GnssInsOptions& options, const OutagePlan& plan,
                                  const std::map<LogTime, double>& plain, const Options& o) {
  OutageVariant variant{name, {}, {}};
  std::map<std::pair<std::size_t, LogTime>, std::vector<std::pair<double, double>>> outside;
  std::mutex mutex;
  const auto run = [&](const OutageWindow& window) -> Result<NavTrajectory> {
    GnssInsRecording recording = drive.recording;
    recording.ranges =
        mask_satellites(recording.ranges, window, drive.antenna_truth(window.begin).position);
    const auto result =
        o.smooth ? smooth_gnss_ins(recording, options) : run_gnss_ins(recording, options);
    if (!result) return result.error();
    NavTrajectory track = antenna_track(result->points, options);
    auto pairs = outside_of(window, track, plain, drive);
    const std::lock_guard lock(mutex);
    outside[{window.satellites_left, window.begin}] = std::move(pairs);
    return track;
  };
  ProgressLine progress(name, o.quiet);
  auto report = run_outages(plan, run, drive.antenna_truth, std::ref(progress));
  if (!report) return report.error();
  progress.finish();
  variant.report = *std::move(report);
  for (const auto& [key, pairs] : outside) {
    for (const auto& [filter, alone] : pairs) {
      variant.outside.filter.push_back(filter);
      variant.outside.plain.push_back(alone);
    }
  }
  return variant;
}

std::string description_of(const Options& o, const KnownDrive& drive) {
  const std::string ranges =
      std::to_string(o.ranges.satellites) + " satellites, " +
      eval::fixed(o.ranges.range_sigma_m, 1) + " m, " + eval::fixed(o.ranges.rate_sigma_mps, 2) +
      " m/s, every " + eval::fixed(o.ranges.period_s, 2) + " s, seed " +
      std::to_string(o.ranges.seed) + (o.ranges.phases ? ", carrier phases" : "") +
      (o.wheels ? ", simulated wheels" : "");
  const std::string constraints =
      " Constraints: wheels do not move sideways; standstill is detected with and without them.";
  if (o.simulated)
    return "All simulated: drive, inertial unit, and ranges (" + ranges + ")." + constraints;
  if (drive.recorded_ranges)
    return "Real inertial readings of " + drive.name + " and its recorded ranges (" +
           std::to_string(drive.recording.ranges.size()) +
           " epochs), compared with the recording's reference." + constraints;
  return "Real inertial readings of " + drive.name +
         "; the ranges are simulated along the reference of the recording (" + ranges + ")." +
         constraints;
}

/// With the sensors that the options ask for.
Result<KnownDrive> recorded_or_simulated(const Options& o) {
  if (o.simulated) return simulated_drive(o.ranges);
  const auto config = read_nav_config(o.config);
  if (!config) return config.error();
  return recorded_drive(o.files, *config, o.ranges);
}

Result<KnownDrive> drive_of(Options& o) {
  if (o.wheels) o.ranges.wheels.emplace().scale = o.wheel_scale;
  auto drive = recorded_or_simulated(o);
  if (!drive) return drive;
  if (o.wheels && !drive->options.odometer) drive->options.odometer.emplace();
  if (o.ranges.phases && !drive->options.carrier_phase) drive->options.carrier_phase.emplace();
  return drive;
}

/// Distributed over the drive after the filter has settled.
Result<OutagePlan> plan_of(const Options& o, const KnownDrive& drive) {
  OutagePlan plan;
  plan.threads = o.threads;
  // What is smoothed depends on the end of the outage.
  if (o.smooth) plan.durations = {plan.durations.back()};
  if (!o.left.empty()) plan.satellites_left.clear();
  for (const double n : o.left)
    plan.satellites_left.push_back(static_cast<std::size_t>(std::max(n, 0.0)));
  const LogTime begin = drive.recording.imu.front().time;
  const LogTime end = std::min(drive.recording.imu.back().time, drive.recording.ranges.back().time);
  const LogTime first = begin + from_seconds(o.first_s);
  if (end - first < plan.durations.back())
    return Error{ErrorCode::invalid, "the drive is too short for an outage of 30 s after " +
                                         eval::fixed(o.first_s, 0) + " s"};
  plan.starts = outage_starts(first, end, plan.durations.back(), o.places, drive.recording.ranges);
  return plan;
}

Result<void> run(Options& o) {
  if (!o.simulated && (o.files.imu.empty() || o.files.truth.empty()))
    return bad_use("a recorded drive needs --imu and --truth; or --simulated");
  if (auto ready = o.prepare({"outages.txt", "report.html"}); !ready) return ready;
  const auto drive = drive_of(o);
  if (!drive) return drive.error();
  for (const std::string& remark : drive->remarks)
    std::fprintf(stderr, "note: %s\n", remark.c_str());
  const auto plan = plan_of(o, *drive);
  if (!plan) return plan.error();
  const auto plain = plain_errors(*drive);
  std::vector<OutageVariant> variants;
  for (const bool constraints : {false, true}) {
    GnssInsOptions options = drive->options;
    options.non_holonomic_in_outage = constraints;
    auto variant = run_variant(constraints ? "with constraints" : "without constraints", *drive,
                               options, *plan, plain, o);
    if (!variant) return variant.error();
    variants.push_back(*std::move(variant));
  }
  const auto tables = outage_tables(variants, o.places);
  const std::string description = description_of(o, *drive);
  const std::string text = description + "\n" + to_text(tables);
  const io::Report report =
      outage_report("Satellite outages: " + drive->name, description, variants, tables);
  const auto done =
      first_error({io::write_file(o.path("outages.txt"), text, o.write()), o.write_report(report)});
  if (done && !o.quiet)
    std::printf("%s\nreport: %s\n", text.c_str(), o.path("report.html").c_str());
  return done;
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine app(
      "Drift of inertial navigation in satellite outages of 10 to 30 s with none to four "
      "satellites left.\nReal inertial readings with recorded ranges, or with ranges simulated "
      "along the recording's reference, or an entirely simulated drive. Writes outages.txt and "
      "report.html.");
  Options o;
  app.add_flag("--simulated", o.simulated, "a simulated drive of 310 s and 4.5 km");
  app.add_option("--imu", o.files.imu,
                 "inertial samples; two files if gyro and accelerometer are separate")
      .existing_file()
      .expected(1, 2);
  app.add_option("--imu-tags", o.files.imu_tags, "RTKLIB's time tags of the inertial file")
      .existing_file();
  app.add_option("--imu-clock", o.files.imu_clock, "pairs of the unit's times and GPS times")
      .existing_file();
  app.add_option("--truth", o.files.truth,
                 "the reference, along which the ranges are simulated unless they are recorded")
      .existing_file();
  add_recorded_ranges(app, o.files);
  app.add_option("--config", o.config, "JSON description of the recording; see gnss_ins")
      .existing_file();
  add_imu_topic(app, o.files.topics);
  add_out(app, o);
  app.add_option("--seed", o.ranges.seed, kSeedHelp).show_default();
  app.add_option("--satellites", o.ranges.satellites, "largest number of satellites")
      .show_default();
  app.add_option("--range-sigma", o.ranges.range_sigma_m, "noise of a range, m")
      .positive()
      .show_default();
  app.add_option("--rate-sigma", o.ranges.rate_sigma_mps, "noise of a range rate, m/s")
      .positive()
      .show_default();
  app.add_option("--period", o.ranges.period_s, "interval of range epochs, s")
      .range(0.05, 60.0)
      .show_default();
  app.add_option("--places", o.places, "number of start times, distributed over the drive")
      .range(1, 1000)
      .show_default();
  o.first_s = 100.0;
  app.add_option("--first", o.first_s, "the first start time, s after the first sample")
      .range(0.0, 1e6)
      .show_default();
  app.add_flag("--wheels", o.wheels,
               "with the speeds of wheels, simulated along the reference: noise 0.03 m/s, steps of "
               "0.02 m/s");
  app.add_number("--wheel-scale", o.wheel_scale, -0.5, 0.5, "relative error of the wheels' speed");
  app.add_flag("--phases", o.ranges.phases,
               "with carrier phases, recorded or simulated: simulated ones have 3 mm of noise");
  app.add_flag("--smooth", o.smooth,
               "estimate each instant by all measurements, in outages of 30 s only");
  app.add_option("--left", o.left, "numbers of satellites that stay; else 0 to 4").expected(1, 5);
  app.add_option("--threads", o.threads, kThreadsHelp).range(1, 256).show_default();
  add_force_and_quiet(app, o);
  add_json(app, o);
  app.example("--simulated --out outages", "a simulated drive");
  app.example("--imu imu.txt --ranges ranges.txt --truth truth.txt --out outages",
              "a recorded one");
  if (const auto code = app.parse(argc, argv)) return *code;
  return exit_code("outage_test", run(o));
}
