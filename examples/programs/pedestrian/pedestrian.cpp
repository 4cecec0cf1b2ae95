// Pedestrian dead reckoning from a recorded unit on the body or on a foot.

#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <string>

#include <wayfare/pedestrian/foot_tracker.hpp>
#include <wayfare/pedestrian/pedestrian.hpp>

#include "ahrs/recording.hpp"
#include "outputs.hpp"
#include "support/progress_line.hpp"
#include "support/ros_topics.hpp"
#include "support/truth.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

struct Arguments : OutputArguments {
  std::string file, length = "kim", forward = "y";
  bool foot = false, no_magnetometer = false, any_way_round = false;
  bool ared = false, uncalibrated = false;
  double factor = 0.0, height_m = 1.75, declination_deg = 0.0, straight_degps = 0.0;
  double gyro_range_degps = 2000.0;
  RecordingOptions recording;
  TruthOptions truth;
};

using Progress = std::function<void(double)>;

void update(const Progress& progress, std::size_t i, std::size_t n) {
  if (i % 4096 == 0) progress(static_cast<double>(i) / static_cast<double>(n));
}

std::string readings(const SensorReport& r) {
  return std::to_string(r.used) + " used, " + std::to_string(r.missing) + " missing, " +
         std::to_string(r.late) + " late, " + std::to_string(r.saturated) + " saturated";
}

WalkRun run_steps(const MargRecording& samples, const PedestrianParameters& parameters,
                  const Progress& progress) {
  Pedestrian pedestrian(parameters);
  WalkRun run;
  const auto keep = [&](const PedestrianPose& p) {
    const Eigen::Vector2d sigma = p.covariance.diagonal().head<2>().cwiseSqrt();
    run.rows.push_back({p.time,
                        {p.position_m.x(), p.position_m.y(), 0.0},
                        p.heading,
                        {sigma.x(), sigma.y(), 0.0},
                        p.length_m,
                        p.step.interval_s,
                        0.0,
                        true});
  };
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const MargUpdateStatus status = pedestrian.add(samples[i], keep);
    if (status.accelerometer == UpdateStatus::used ||
        status.accelerometer == UpdateStatus::saturated)
      run.force.emplace_back(samples[i].time, samples[i].specific_force_mps2.norm());
    update(progress, i, samples.size());
  }
  const PedestrianReport report = pedestrian.report();
  run.events = report.steps;
  run.walked_m = report.distance_m;
  run.facts = {
      {"gyro", readings(report.ahrs.gyro)},
      {"accelerometer", readings(report.ahrs.accelerometer)},
      {"magnetometer", readings(report.ahrs.magnetometer) + ", " +
                           std::to_string(report.ahrs.magnetometer.disturbed) + " disturbed"},
      {"attitude restarts", std::to_string(report.ahrs.restarts)},
      {"steps without a heading", std::to_string(report.without_heading)}};
  return run;
}

WalkRun run_foot(const MargRecording& samples, const FootParameters& parameters,
                 const Progress& progress) {
  FootTracker tracker(parameters);
  WalkRun run;
  run.foot = true;
  Eigen::Vector3d last = Eigen::Vector3d::Zero();
  const auto keep = [&](const FootPose& p) {
    WalkRow row{p.time, p.position_m, p.heading,   p.position_covariance_m2.diagonal().cwiseSqrt(),
                0.0,    0.0,          p.statistic, p.stance > 0.5};
    if (row.event) {
      row.step_m = (p.position_m - last).head<2>().norm();
      run.walked_m += row.step_m;
      last = p.position_m;
    }
    run.rows.push_back(row);
  };
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const MargSample& s = samples[i];
    tracker.add({s.time, s.angular_rate_radps, s.specific_force_mps2}, keep);
    update(progress, i, samples.size());
  }
  tracker.finish(keep);
  const FootReport& report = tracker.report();
  run.events = report.stances;
  run.facts = {{"gyro", readings(report.gyro)},
               {"accelerometer", readings(report.accelerometer)},
               {"unreliable stances", std::to_string(report.rejected)},
               {"gaps", std::to_string(report.gaps)},
               {"reinitialised", std::to_string(report.lost)}};
  return run;
}

StepLength length_model(const Arguments& a) {
  StepLength model = KimStep{};
  if (a.length == "constant") model = ConstantStep{};
  if (a.length == "weinberg") model = WeinbergStep{};
  if (a.length == "frequency") model = HeightFrequencyStep{0.3139, a.height_m};
  if (a.factor > 0.0) std::visit([&](auto& m) { m.factor = a.factor; }, model);
  return model;
}

WalkRun walk(const Arguments& a, const io::MargFile& file) {
  ProgressLine progress("walk", a.quiet);
  WalkRun run;
  if (a.foot) {
    FootParameters p;
    p.rate_range = Angle::degrees(0.997 * a.gyro_range_degps).radians();
    if (a.ared) p.statistic = StanceStatistic::ared;
    run = run_foot(file.samples, p, std::ref(progress));
  } else {
    PedestrianParameters p;
    p.length = length_model(a);
    p.straight.bias_sigma_radps = Angle::degrees(a.straight_degps).radians();
    p.magnetic_drift.offset_sigma_uT = a.uncalibrated ? 50.0 : 0.0;
    p.ahrs.use_magnetometer = !a.no_magnetometer && file.has_magnetometer;
    p.ahrs.declination = Angle::degrees(a.declination_deg);
    p.axis = a.any_way_round ? WalkingAxis::principal : WalkingAxis::sensor;
    p.forward = (a.forward[0] == '-' ? -1.0 : 1.0) * Eigen::Vector3d::Unit(a.forward.back() - 'x');
    run = run_steps(file.samples, p, std::ref(progress));
  }
  progress.finish();
  return run;
}

/// Of --truth, else of the recording.
Result<Truth> truth_of(const Arguments& a, const MargRecording& samples) {
  Trajectory own;
  if (a.truth.file.empty() && ros::RecordingFile::is_one(a.file)) {
    const auto file = ros::RecordingFile::open(a.file);
    if (!file) return file.error();
    auto recorded = ros::read_truth(*file, a.recording.topics);
    if (!recorded) return recorded.error();
    print_problems(recorded->problems);
    own = std::move(recorded->truth);
  }
  std::vector<LogTime> times;
  for (const MargSample& sample : samples) times.push_back(sample.time);
  return a.truth.read(a.file, std::move(own), times, a.recording.topics);
}

Result<void> run(const Arguments& a) {
  if (auto ready = a.prepare({"track.csv", "trajectory.tum", "report.html"}); !ready) return ready;
  const auto file = a.recording.read(a.file);
  if (!file) return file.error();
  const auto truth = truth_of(a, file->samples);
  if (!truth) return truth.error();
  const WalkRun run = walk(a, *file);
  if (run.rows.empty())
    return Error{ErrorCode::degenerate,
                 a.foot ? "gives no attitude: no reading of gyro and accelerometer near gravity"
                        : "contains no walk: no sequence of steps with an attitude",
                 a.file};
  const auto title = "Walk: " + std::filesystem::path(a.file).filename().string();
  if (auto done = write_walk_outputs(a, title, run, *truth); !done || a.quiet) return done;
  std::printf("%sreport: %s\n", walk_text(run, *truth).c_str(), a.path("report.html").c_str());
  return {};
}

void add_options(CommandLine& app, Arguments& a) {
  RecordingOptions::add_path(app, "FILE", a.file);
  add_out(app, a);
  a.truth.add_options(app);
  add_truth_topics(app, a.recording.topics);
  app.add_flag("--foot", a.foot, "the unit is on a foot, with zero velocity in stance phases");
  app.add_flag("--ared", a.ared, "detect stance phases by the gyro alone (with --foot)");
  app.add_positive("--gyro-range", a.gyro_range_degps, "of the unit, deg/s (with --foot)");
  app.add_option("--length", a.length, "step length model")
      .one_of({"kim", "constant", "weinberg", "frequency"})
      .show_default();
  app.add_option("--factor", a.factor, "the model's factor, from a walk of known length")
      .positive();
  app.add_positive("--height", a.height_m, "of the walker, metres (with --length frequency)");
  app.add_option("--forward", a.forward, "the unit's axis in the direction of walking")
      .one_of({"x", "y", "z", "-x", "-y", "-z"})
      .show_default();
  app.add_flag("--any-way-round", a.any_way_round,
               "find the direction of walking from the body's motion");
  app.add_flag("--no-magnetometer", a.no_magnetometer, "use gyro and accelerometer alone");
  app.add_flag("--uncalibrated", a.uncalibrated,
               "the magnetometer is not calibrated: its offset is estimated during the walk, and "
               "headings are relative to the start");
  app.add_number("--declination", a.declination_deg, -180.0, 180.0,
                 "of magnetic from true north, degrees, east positive");
  app.add_number("--straight", a.straight_degps, 0.0, 5.0,
                 "standard deviation of the gyro bias, deg/s, estimated as the most frequent yaw "
                 "rate: 0.2 for paths with straight segments");
  add_force_and_quiet(app, a);
  a.recording.add_options(app);
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine app(
      "Pedestrian dead reckoning from a recorded unit with gyro and accelerometer, on the body or "
      "(--foot) on a foot. Writes track.csv, trajectory.tum and report.html.");
  Arguments arguments;
  add_options(app, arguments);
  if (const auto code = app.parse(argc, argv)) return *code;
  return exit_code("pedestrian", run(arguments));
}
