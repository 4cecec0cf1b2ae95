// Pedestrian dead reckoning from a recorded unit on the body or on a foot.

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>
#include <string>

#include <wayfare/io/tum.hpp>

#include "ahrs/recording.hpp"
#include "run.hpp"
#include "support/progress_line.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

struct Arguments : OutputArguments {
  std::string file, truth, length = "kim", forward = "y";
  bool foot = false, no_magnetometer = false, any_way_round = false;
  bool ared = false, uncalibrated = false;
  double factor = 0.0, height_m = 1.75, declination_deg = 0.0, straight_degps = 0.0;
  double gyro_range_degps = 2000.0;
  RecordingOptions recording;
};

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

Result<void> run(const Arguments& a) {
  if (auto ready = a.prepare(walk_output_names()); !ready) return ready;
  const auto file = a.recording.read(a.file);
  if (!file) return file.error();
  Trajectory truth;
  if (!a.truth.empty()) {
    const auto known = io::read_tum(a.truth);
    if (!known) return known.error();
    truth = io::planar(known->trajectory);
    std::stable_sort(truth.begin(), truth.end(),
                     [](const auto& x, const auto& y) { return x.time < y.time; });
  }
  const WalkRun run = walk(a, *file);
  if (run.rows.empty())
    return Error{ErrorCode::degenerate,
                 a.foot ? "gives no attitude: no reading of gyro and accelerometer near gravity"
                        : "contains no walk: no sequence of steps with an attitude",
                 a.file};
  const auto title = "Walk: " + std::filesystem::path(a.file).filename().string();
  if (auto done = write_walk_outputs(a, title, run, truth); !done || a.quiet) return done;
  std::printf("%sreport: %s\n", walk_text(run, truth).c_str(), a.path("report.html").c_str());
  return {};
}

void add_options(CommandLine& app, Arguments& a) {
  RecordingOptions::add_path(app, "FILE", a.file);
  add_out(app, a);
  app.add_file("--truth", a.truth, "true positions on the same clock, TUM text, to compare with");
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
