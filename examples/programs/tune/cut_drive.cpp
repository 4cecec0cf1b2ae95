// Part of a recorded drive as a folder for tune: readings of the unit, ranges recorded or simulated
// along the recording's reference, and that reference.

#include <cstdio>
#include <string>

#include <wayfare/eval/nav_error.hpp>
#include <wayfare/io/nav_text.hpp>

#include "support/command_line.hpp"
#include "support/nav_drives.hpp"
#include "support/program_files.hpp"
#include "support/ros_topics.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

struct Options : OutputArguments {
  NavFiles files;
  RangeSimulation ranges;
  std::string config;
  double from_s = 0.0, to_s = 1e9;
};

Result<void> run(const Options& o) {
  if (auto ready = o.prepare({"imu.txt", "ranges.txt", "truth.txt", "config.json"}); !ready)
    return ready;
  const auto config = read_nav_config(o.config);
  if (!config) return config.error();
  const auto drive = recorded_drive(o.files, *config, o.ranges);
  if (!drive) return drive.error();
  const LogTime zero = drive->recording.imu.front().time;
  const LogTime from = zero + from_seconds(o.from_s),
                to = zero + from_seconds(std::min(o.to_s, 1e8));
  const auto outside = [&](const auto& m) { return m.time < from || m.time > to; };
  std::vector<ImuSample> imu = drive->recording.imu;
  std::erase_if(imu, outside);
  std::vector<RangeEpoch> ranges = drive->recording.ranges;
  std::erase_if(ranges, outside);
  NavTrajectory truth;
  // Every tenth of a second: the reference is a smooth curve through the recorded states.
  const Eigen::Vector3d lever = -config->filter.antenna_lever_arm_m;
  if (!ranges.empty())
    for (LogTime t = ranges.front().time; t <= ranges.back().time;
         t += std::chrono::milliseconds(100))
      truth.push_back(eval::at_lever_arm(drive->antenna_truth(t), lever));
  if (imu.empty() || truth.empty()) return bad_use("there are no data between --from and --to");
  NavConfig cut;
  cut.filter = config->filter;
  cut.truth_is_antenna = false;
  // The reference's attitude is its course: roll and pitch are unknown.
  cut.truth_is_true = false;
  cut.note = "cut from " + drive->name;
  const auto done =
      first_error({io::write_imu(o.path("imu.txt"), imu, o.write()),
                   io::write_ranges(o.path("ranges.txt"), ranges, o.write()),
                   io::write_nav(o.path("truth.txt"), truth, o.write()),
                   io::write_file(o.path("config.json"), format_nav_config(cut), o.write())});
  if (!done) return done;
  std::printf("%s: %zu inertial readings, %zu range epochs\n", o.out.c_str(), imu.size(),
              ranges.size());
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine app(
      "Extract part of a recorded drive for tune: the unit's readings are real, the ranges "
      "recorded "
      "or simulated along the recording's reference, whose attitude is the course.");
  Options o;
  app.add_file("--imu", o.files.imu,
               "inertial samples; two files if gyro and accelerometer are separate")
      .required()
      .expected(1, 2);
  app.add_file("--imu-tags", o.files.imu_tags, "RTKLIB's time tags of the inertial file");
  app.add_file("--imu-clock", o.files.imu_clock, "pairs of the unit's times and GPS times");
  app.add_file("--truth", o.files.truth,
               "the reference, along which the ranges are simulated unless they are recorded")
      .required();
  add_recorded_ranges(app, o.files);
  app.add_file("--config", o.config, "JSON description of the recording; see gnss_ins");
  app.add_option("--from", o.from_s, "begin, seconds after the first sample").show_default();
  app.add_option("--to", o.to_s, "end, seconds after the first sample");
  app.add_option("--seed", o.ranges.seed, kSeedHelp).show_default();
  app.add_option("--satellites", o.ranges.satellites, "largest number of satellites")
      .show_default();
  add_imu_topic(app, o.files.topics);
  add_out(app, o);
  app.add_flag("--force", o.force, "replace existing files");
  app.example("--imu imu.txt --truth truth.txt --from 20 --to 120 --out drive1",
              "100 s of a recorded drive");
  if (const auto code = app.parse(argc, argv)) return *code;
  return exit_code("cut_drive", run(o));
}
