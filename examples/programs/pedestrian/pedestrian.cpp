// Pedestrian dead reckoning from a recorded unit on the body, on a foot or on each foot.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "ahrs/recording.hpp"
#include "outputs.hpp"
#include "step_length_options.hpp"
#include "support/progress_line.hpp"
#include "support/ros_topics.hpp"
#include "support/truth.hpp"
#include "two_feet.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

struct Arguments : OutputArguments {
  std::string file, forward = "y";
  bool foot = false, no_magnetometer = false, any_way_round = false;
  bool ared = false, uncalibrated = false, mean_field = false;
  double declination_deg = 0.0, straight_degps = 0.0, held_deg = 0.0;
  double gyro_range_degps = 2000.0;
  std::optional<double> known_length_m;
  StepLengthOptions length;
  BarometricHeightParameters barometer;
  RecordingOptions recording;
  RightFoot right;
  TruthOptions truth;

  [[nodiscard]] bool two_feet() const { return !right.file.empty(); }
};

constexpr const char* kCalibration = "calibration.json";

FootParameters foot_parameters(const Arguments& a) {
  FootParameters p;
  p.rate_range = Angle::degrees(0.997 * a.gyro_range_degps).radians();
  if (a.ared) p.statistic = StanceStatistic::ared;
  return p;
}

PedestrianParameters step_parameters(const Arguments& a, const io::MargFile& file,
                                     const StepLength& length) {
  PedestrianParameters p;
  p.length = length;
  p.straight.bias_sigma_radps = Angle::degrees(a.straight_degps).radians();
  p.magnetic_drift.offset_sigma_uT = a.uncalibrated ? 50.0 : 0.0;
  p.mean_field.on = a.mean_field;
  p.ahrs.use_magnetometer = !a.no_magnetometer && file.has_magnetometer;
  p.ahrs.declination = Angle::degrees(a.declination_deg);
  p.axis = a.any_way_round ? WalkingAxis::principal : WalkingAxis::sensor;
  p.forward = Eigen::AngleAxisd(Angle::degrees(a.held_deg).radians(), Eigen::Vector3d::UnitZ()) *
              ((a.forward[0] == '-' ? -1.0 : 1.0) * Eigen::Vector3d::Unit(a.forward.back() - 'x'));
  return p;
}

/// A second pass with the length by which the steps of the first add up to the known one.
Result<WalkRun> calibrated_walk(const Arguments& a, const io::MargFile& file, const WalkRun& first,
                                const StepLength& length, const WalkProgress& progress) {
  const auto model = calibrated_to(length, first.steps, *a.known_length_m);
  if (!model) return Error{model.error().code, model.error().message, a.file};
  WalkRun run = run_steps(file.samples, step_parameters(a, file, *model), progress);
  const std::string path = a.path(kCalibration);
  if (auto done =
          write_step_calibration(path, *model, *a.known_length_m, run.steps.size(), a.write());
      !done)
    return done.error();
  run.facts.emplace_back("step length factor", eval::fixed(factor_of(*model), 5) + " (" +
                                                   name_of(*model) + "), saved to " + path);
  return run;
}

Result<WalkRun> walk(const Arguments& a, const io::MargFile& file) {
  const auto length = a.length.model();
  if (!length) return length.error();
  ProgressLine progress("walk", a.quiet);
  const WalkProgress update = std::ref(progress);
  Result<WalkRun> run = a.foot ? run_foot(file.samples, foot_parameters(a), update)
                               : run_steps(file.samples, step_parameters(a, file, *length), update);
  if (run->rows.empty())
    return Error{ErrorCode::degenerate,
                 a.foot ? "gives no attitude: no reading of gyro and accelerometer near gravity"
                        : "contains no walk: no sequence of steps with an attitude",
                 a.file};
  if (a.known_length_m) run = calibrated_walk(a, file, *run, *length, update);
  progress.finish();
  if (!run) return run;
  BarometricHeightParameters barometer = a.barometer;
  if (!a.foot) barometer.height_walk_m = 0.3;  // stairs
  add_heights(*run, file, barometer);
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

Result<void> run_both_feet(const Arguments& a, const io::MargFile& left, const Truth& truth) {
  const auto right = a.right.read(a.recording);
  if (!right) return right.error();
  const auto run = run_two_feet(left.samples, right->samples, foot_parameters(a), a.right);
  if (!run) return Error{run.error().code, run.error().message, a.right.file};
  const auto title = "Two feet: " + std::filesystem::path(a.file).filename().string() + ", " +
                     std::filesystem::path(a.right.file).filename().string();
  if (auto done = write_two_feet(a, title, *run, truth); !done || a.quiet) return done;
  std::printf("%sreport: %s\n", two_feet_text(*run, truth).c_str(), a.path("report.html").c_str());
  return {};
}

Result<void> check(const Arguments& a) {
  if (a.known_length_m && !(*a.known_length_m > 0.0 && std::isfinite(*a.known_length_m)))
    return bad_use("--known-length must be a positive number of metres");
  std::vector<std::string> names = {"track.csv", "trajectory.tum", "report.html"};
  if (a.two_feet()) names = {"left.tum", "right.tum", "trajectory.tum", "report.html"};
  if (a.known_length_m) names.emplace_back(kCalibration);
  return a.prepare(names);
}

Result<void> run(const Arguments& a) {
  if (auto ready = check(a); !ready) return ready;
  const auto file = a.recording.read(a.file);
  if (!file) return file.error();
  const auto truth = truth_of(a, file->samples);
  if (!truth) return truth.error();
  if (a.two_feet()) return run_both_feet(a, *file, *truth);
  const auto run = walk(a, *file);
  if (!run) return run.error();
  const auto title = "Walk: " + std::filesystem::path(a.file).filename().string();
  if (auto done = write_walk_outputs(a, title, *run, *truth); !done || a.quiet) return done;
  std::printf("%sreport: %s\n", walk_text(*run, *truth).c_str(), a.path("report.html").c_str());
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
  a.length.add_options(app);
  app.add_option("--known-length", a.known_length_m,
                 "length of this walk, metres: finds the step length factor, prints it and saves "
                 "it to calibration.json in --out, for --calibration")
      .excludes("--factor")
      .excludes("--foot");
  app.add_option("--forward", a.forward, "the unit's axis in the direction of walking")
      .one_of({"x", "y", "z", "-x", "-y", "-z"})
      .show_default();
  app.add_number("--held", a.held_deg, -180.0, 180.0,
                 "direction of walking from the --forward axis, degrees about the unit's z axis, "
                 "counter-clockwise: a phone in the hand points past it to the left (-3.5)");
  app.add_flag("--any-way-round", a.any_way_round,
               "find the direction of walking from the body's motion");
  app.add_flag("--no-magnetometer", a.no_magnetometer, "use gyro and accelerometer alone");
  app.add_flag("--uncalibrated", a.uncalibrated,
               "the magnetometer is not calibrated: its offset is estimated during the walk, and "
               "headings are relative to the start");
  app.add_flag("--mean-field", a.mean_field,
               "headings by the gyro alone, and north by the mean field of the whole walk: for "
               "minutes inside buildings")
      .excludes("--no-magnetometer")
      .excludes("--uncalibrated");
  app.add_number("--declination", a.declination_deg, -180.0, 180.0,
                 "of magnetic from true north, degrees, east positive");
  app.add_number("--straight", a.straight_degps, 0.0, 5.0,
                 "standard deviation of the gyro bias, deg/s, estimated as the most frequent yaw "
                 "rate: 0.2 for paths with straight segments");
  app.add_positive("--pressure-noise", a.barometer.pressure_sigma_Pa,
                   "white noise of a reading of the barometer (column p), Pa");
  app.add_positive("--pressure-drift", a.barometer.pressure_drift_Pa,
                   "random walk of the pressure, Pa/sqrt(s)");
  a.right.add_options(app);
  add_force_and_quiet(app, a);
  add_json(app, a);
  a.recording.add_options(app);
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine app(
      "Pedestrian dead reckoning from a recorded unit with gyro and accelerometer, on the body, "
      "(--foot) on a foot or (--right) on each foot. Writes track.csv, trajectory.tum and "
      "report.html; with --right left.tum and right.tum instead of track.csv.");
  Arguments arguments;
  add_options(app, arguments);
  app.example("walk.csv --out walk", "the path of a walk with the unit on the body");
  app.example("walk.csv --known-length 60 --out walk",
              "finds the step length factor on a walk of 60 m");
  app.example("left.csv --right right.csv --out walk", "a unit on each foot");
  if (const auto code = app.parse(argc, argv)) return *code;
  return exit_code("pedestrian", run(arguments));
}
