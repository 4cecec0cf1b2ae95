// Where somebody walked, from a recorded unit on the body or on a foot.

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>
#include <string>

#include <wayfare/io/tum.hpp>

#include "ahrs/recording.hpp"
#include "outputs.hpp"
#include "run.hpp"
#include "support/command_line.hpp"
#include "support/exit_code.hpp"
#include "support/progress_line.hpp"

namespace {

using namespace wayfare;

struct Arguments {
  std::string file, out, truth, length = "kim", forward = "y";
  bool foot = false, force = false, quiet = false, no_magnetometer = false, any_way_round = false;
  bool ared = false, uncalibrated = false;
  double factor = 0.0, height_m = 1.75, declination_deg = 0.0, straight_degps = 0.0;
  double gyro_range_degps = 2000.0;
  examples::RecordingOptions recording;
};

StepLength length_model(const Arguments& a) {
  StepLength model = KimStep{};
  if (a.length == "constant") model = ConstantStep{};
  if (a.length == "weinberg") model = WeinbergStep{};
  if (a.length == "frequency") model = HeightFrequencyStep{0.3139, a.height_m};
  if (a.factor > 0.0) std::visit([&](auto& m) { m.factor = a.factor; }, model);
  return model;
}

examples::WalkRun walk(const Arguments& a, const io::MargFile& file) {
  examples::ProgressLine line("walk", a.quiet);
  const auto progress = [&](double part) { line.update(part); };
  examples::WalkRun done;
  if (a.foot) {
    FootParameters p;
    p.rate_range = Angle::degrees(0.997 * a.gyro_range_degps).radians();
    if (a.ared) p.statistic = StanceStatistic::ared;
    done = examples::run_foot(file.samples, p, progress);
  } else {
    PedestrianParameters p;
    p.length = length_model(a);
    p.straight.bias_sigma_radps = Angle::degrees(a.straight_degps).radians();
    p.magnetic_drift.offset_sigma_uT = a.uncalibrated ? 50.0 : 0.0;
    p.ahrs.use_magnetometer = !a.no_magnetometer && file.has_magnetometer;
    p.ahrs.declination = Angle::degrees(a.declination_deg);
    p.axis = a.any_way_round ? WalkingAxis::principal : WalkingAxis::sensor;
    p.forward = (a.forward[0] == '-' ? -1.0 : 1.0) * Eigen::Vector3d::Unit(a.forward.back() - 'x');
    done = examples::run_steps(file.samples, p, progress);
  }
  line.finish();
  return done;
}

Result<void> run(const Arguments& a) {
  const io::WriteOptions write{a.force ? io::Existing::replace : io::Existing::refuse};
  if (auto free = examples::prepare_walk_folder(a.out, write); !free) return free;
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
  const examples::WalkRun done = walk(a, *file);
  if (done.rows.empty())
    return Error{ErrorCode::degenerate,
                 a.foot ? "gives no attitude: no reading of gyro and accelerometer near gravity"
                        : "holds no walk: no row of steps with an attitude",
                 a.file};
  const auto title = "Walk: " + std::filesystem::path(a.file).filename().string();
  const auto report = examples::write_walk_outputs(a.out, title, done, truth, write);
  if (!report) return report.error();
  if (a.quiet) return {};
  std::printf("%sreport: %s\n", examples::walk_text(done, truth).c_str(), report->c_str());
  return {};
}

void describe(examples::CommandLine& app, Arguments& a) {
  examples::RecordingOptions::add_path(app, "FILE", a.file);
  app.add_option("--out", a.out, "folder for the results, made where needed").required();
  app.add_option("--truth", a.truth,
                 "true positions by the same clock, TUM text: drawn beside, and compared")
      .existing_file();
  app.add_flag("--foot", a.foot, "the unit is on a foot: velocity is zero where it stands");
  app.add_flag("--ared", a.ared, "stances by the gyro alone (with --foot)");
  app.add_option("--gyro-range", a.gyro_range_degps, "degrees a second (with --foot)")
      .positive()
      .show_default();
  app.add_option("--length", a.length, "model of the step's length")
      .one_of({"kim", "constant", "weinberg", "frequency"})
      .show_default();
  app.add_option("--factor", a.factor, "the model's factor, from a walk of known length")
      .positive();
  app.add_option("--height", a.height_m, "of the walker, metres (with --length frequency)")
      .positive()
      .show_default();
  app.add_option("--forward", a.forward, "the unit's axis that points where one walks")
      .one_of({"x", "y", "z", "-x", "-y", "-z"})
      .show_default();
  app.add_flag("--any-way-round", a.any_way_round, "find it from how the body sways");
  app.add_flag("--no-magnetometer", a.no_magnetometer, "gyro and accelerometer alone");
  app.add_flag("--uncalibrated", a.uncalibrated,
               "the magnetometer was never calibrated: its iron is found on the way, and headings "
               "count from the start");
  app.add_option("--declination", a.declination_deg, "of magnetic north, degrees east")
      .range(-180.0, 180.0)
      .show_default();
  app.add_option("--straight", a.straight_degps,
                 "take the rate of turning that returns most often for the gyro's bias, of this "
                 "size, degrees a second: 0.2 for ways of straight pieces")
      .range(0.0, 5.0)
      .show_default();
  app.add_flag("--force", a.force, "replace files of an earlier run");
  app.add_flag("--quiet", a.quiet, "no progress and no tables");
  a.recording.describe(app);
}

}  // namespace

int main(int argc, char** argv) {
  examples::CommandLine app(
      "Find out where somebody walked from a recorded unit with gyro and accelerometer, on the "
      "body "
      "or (--foot) on a foot. Writes track.csv, trajectory.tum and report.html.");
  Arguments arguments;
  describe(app, arguments);
  if (const auto code = app.parse(argc, argv)) return *code;
  return examples::exit_code("pedestrian", run(arguments));
}
