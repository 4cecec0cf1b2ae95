// How far inertial navigation drifts where satellites are missing: outages of 10 to 30 s with none
// to four satellites left, each at ten places of a drive.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/gnss/single_point.hpp>
#include <wayfare/io/report.hpp>
#include <wayfare/nav/outage.hpp>

#include "outage_results.hpp"
#include "support/command_line.hpp"
#include "support/exit_code.hpp"
#include "support/nav_drives.hpp"
#include "support/nav_outputs.hpp"
#include "support/program_files.hpp"
#include "support/progress_line.hpp"
#include "support/ros_topics.hpp"

namespace {

using namespace wayfare;

struct Options {
  examples::NavFiles files;
  examples::RangeSimulation ranges;
  std::string config, out;
  std::size_t places = 10;
  double first_s = 0.0;
  int threads = 1;
  bool simulated = false;
  bool force = false;
  bool quiet = false;
};

NavTrajectory antenna_track(const std::vector<GnssInsPoint>& points,
                            const GnssInsOptions& options) {
  NavTrajectory track;
  track.reserve(points.size());
  for (const GnssInsPoint& p : points)
    track.push_back(
        examples::at_lever_arm(p.nav, options.antenna_lever_arm_m, Eigen::Vector3d::Zero()));
  return track;
}

double horizontal(const Geodetic& a, const Geodetic& b) {
  return ned_from_geodetic(a, b).head<2>().norm();
}

/// Where each epoch alone puts the antenna, by its time.
std::map<LogTime, double> plain_errors(const examples::KnownDrive& drive) {
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

/// At the epochs after the filter has settled and outside of the window.
std::vector<std::pair<double, double>> outside_of(const OutageWindow& window,
                                                  const NavTrajectory& track,
                                                  const std::map<LogTime, double>& plain,
                                                  const examples::KnownDrive& drive) {
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

Result<examples::OutageVariant> run_variant(const std::string& name,
                                            const examples::KnownDrive& drive,
                                            const GnssInsOptions& options, const OutagePlan& plan,
                                            const std::map<LogTime, double>& plain, bool quiet) {
  examples::OutageVariant variant{name, {}, {}, 0};
  std::map<std::pair<std::size_t, LogTime>, std::vector<std::pair<double, double>>> outside;
  std::mutex mutex;
  const auto run = [&](const OutageWindow& window) -> Result<NavTrajectory> {
    GnssInsRecording recording = drive.recording;
    recording.ranges =
        mask_satellites(recording.ranges, window, drive.antenna_truth(window.begin).position);
    const auto result = run_gnss_ins(recording, options);
    if (!result) return result.error();
    NavTrajectory track = antenna_track(result->points, options);
    auto pairs = outside_of(window, track, plain, drive);
    const std::lock_guard lock(mutex);
    outside[{window.satellites_left, window.begin}] = std::move(pairs);
    return track;
  };
  examples::ProgressLine progress(name, quiet);
  auto report = run_outages(plan, run, drive.antenna_truth, [&](double f) { progress.update(f); });
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

std::string how_made(const Options& o, const examples::KnownDrive& drive) {
  const std::string ranges = std::to_string(o.ranges.satellites) + " satellites, " +
                             eval::fixed(o.ranges.range_sigma_m, 1) + " m, " +
                             eval::fixed(o.ranges.rate_sigma_mps, 2) + " m/s, every " +
                             eval::fixed(o.ranges.period_s, 2) + " s, seed " +
                             std::to_string(o.ranges.seed);
  const std::string constraints =
      " Constraints are those of wheels, which do not move sideways; standstill is noticed with "
      "and without them.";
  if (o.simulated)
    return "All simulated: drive, inertial unit, and ranges (" + ranges + ")." + constraints;
  return "Real inertial readings of " + drive.name +
         "; the ranges are simulated along the reference of the recording (" + ranges + ")." +
         constraints;
}

Result<examples::KnownDrive> drive_of(const Options& o) {
  if (o.simulated) return examples::simulated_drive(o.ranges);
  auto config = o.config.empty() ? Result<examples::NavConfig>(examples::NavConfig{})
                                 : examples::read_nav_config(o.config);
  if (!config) return config.error();
  return examples::recorded_drive(o.files, *config, o.ranges);
}

/// Spread over the drive from when the filter has settled.
Result<OutagePlan> plan_of(const Options& o, const examples::KnownDrive& drive) {
  OutagePlan plan;
  plan.threads = o.threads;
  const LogTime begin = drive.recording.imu.front().time;
  const LogTime end = std::min(drive.recording.imu.back().time, drive.recording.ranges.back().time);
  const LogTime first = begin + from_seconds(o.first_s);
  if (end - first < plan.durations.back())
    return Error{ErrorCode::invalid, "the drive is too short for an outage of 30 s after " +
                                         eval::fixed(o.first_s, 0) + " s"};
  plan.starts = outage_starts(first, end, plan.durations.back(), o.places);
  // From an epoch on, so that an outage is as long as it says.
  for (LogTime& place : plan.starts) {
    LogTime epoch = place;
    for (const RangeEpoch& e : drive.recording.ranges)
      if (e.time <= place) epoch = e.time;
    place = epoch;
  }
  return plan;
}

Result<void> run(const Options& o) {
  const io::WriteOptions writing{o.force ? io::Existing::replace : io::Existing::refuse};
  if (!o.simulated && (o.files.imu.empty() || o.files.truth.empty()))
    return Error{ErrorCode::invalid, "a recorded drive needs --imu and --truth; or --simulated"};
  if (auto ready = examples::prepare_files(o.out, {"outages.txt", "report.html"}, writing); !ready)
    return ready;
  const auto drive = drive_of(o);
  if (!drive) return drive.error();
  for (const std::string& remark : drive->remarks)
    std::fprintf(stderr, "note: %s\n", remark.c_str());
  const auto plan = plan_of(o, *drive);
  if (!plan) return plan.error();
  const auto plain = plain_errors(*drive);
  std::vector<examples::OutageVariant> variants;
  for (const bool constraints : {false, true}) {
    GnssInsOptions options = drive->options;
    options.non_holonomic_in_outage = constraints;
    auto variant = run_variant(constraints ? "with constraints" : "without constraints", *drive,
                               options, *plan, plain, o.quiet);
    if (!variant) return variant.error();
    variants.push_back(*std::move(variant));
  }
  const auto tables = examples::outage_tables(variants, o.places);
  std::string text = how_made(o, *drive) + "\n";
  for (const auto& [title, table] : tables) text += "\n" + title + "\n" + table.to_text();
  const auto path = [&](const char* name) {
    return (std::filesystem::path(o.out) / name).string();
  };
  if (auto done = io::write_file(path("outages.txt"), text, writing); !done) return done;
  if (auto done = examples::outage_report("Satellite outages: " + drive->name, how_made(o, *drive),
                                          variants, tables)
                      .write(path("report.html"), writing);
      !done)
    return done;
  if (!o.quiet) std::printf("%s\nreport: %s\n", text.c_str(), path("report.html").c_str());
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  examples::CommandLine app(
      "Take satellites away from a drive for 10 to 30 s, with none to four of them left, and see "
      "how far\ninertial navigation drifts. Real inertial readings with ranges simulated along the "
      "recording's\nreference, or a drive simulated altogether. Writes outages.txt and "
      "report.html.");
  Options o;
  app.add_flag("--simulated", o.simulated, "a simulated drive of 310 s and 4.5 km");
  app.add_option("--imu", o.files.imu, "inertial samples; given twice: gyro and accelerometer")
      .existing_file()
      .expected(1, 2);
  app.add_option("--imu-tags", o.files.imu_tags, "RTKLIB's time tags of the inertial file")
      .existing_file();
  app.add_option("--imu-clock", o.files.imu_clock, "pairs of the unit's times and GPS times")
      .existing_file();
  app.add_option("--truth", o.files.truth, "the reference the ranges are simulated along")
      .existing_file();
  app.add_option("--config", o.config, "JSON description of the recording; see gnss_ins")
      .existing_file();
  examples::add_imu_topic(app, o.files.topics);
  app.add_option("--out", o.out, "folder for the results, made where needed").required();
  app.add_option("--seed", o.ranges.seed, "of all that is simulated").show_default();
  app.add_option("--satellites", o.ranges.satellites, "in view").show_default();
  app.add_option("--range-sigma", o.ranges.range_sigma_m, "m").positive().show_default();
  app.add_option("--rate-sigma", o.ranges.rate_sigma_mps, "m/s").positive().show_default();
  app.add_option("--period", o.ranges.period_s, "between range epochs, s")
      .range(0.05, 60.0)
      .show_default();
  app.add_option("--places", o.places, "where outages begin, spread over the drive")
      .range(1, 1000)
      .show_default();
  o.first_s = 100.0;
  app.add_option("--first", o.first_s, "the first of them, s after the first sample")
      .range(0.0, 1e6)
      .show_default();
  app.add_option("--threads", o.threads, "worker threads; the results do not depend on them")
      .range(1, 256)
      .show_default();
  app.add_flag("--force", o.force, "replace files of an earlier run");
  app.add_flag("--quiet", o.quiet, "no progress and no tables");
  if (const auto code = app.parse(argc, argv)) return *code;
  return examples::exit_code("outage_test", run(o));
}
