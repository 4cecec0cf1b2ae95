// A stretch of a recorded drive as a folder for tune: the unit's own readings, ranges simulated
// along the recording's reference, and that reference.

#include <cstdio>
#include <filesystem>
#include <string>

#include <wayfare/io/nav_text.hpp>

#include "support/command_line.hpp"
#include "support/exit_code.hpp"
#include "support/nav_drives.hpp"
#include "support/nav_errors.hpp"
#include "support/program_files.hpp"
#include "support/ros_topics.hpp"

namespace {

using namespace wayfare;

struct Options {
  examples::NavFiles files;
  examples::RangeSimulation ranges;
  std::string config, out;
  double from_s = 0.0, to_s = 1e9;
  bool force = false;
};

Result<void> run(const Options& o) {
  const io::WriteOptions writing{o.force ? io::Existing::replace : io::Existing::refuse};
  if (auto ready = examples::prepare_files(
          o.out, {"imu.txt", "ranges.txt", "truth.txt", "config.json"}, writing);
      !ready)
    return ready;
  auto config = o.config.empty() ? Result<examples::NavConfig>(examples::NavConfig{})
                                 : examples::read_nav_config(o.config);
  if (!config) return config.error();
  const auto drive = examples::recorded_drive(o.files, *config, o.ranges);
  if (!drive) return drive.error();
  const LogTime zero = drive->recording.imu.front().time;
  const LogTime from = zero + from_seconds(o.from_s),
                to = zero + from_seconds(std::min(o.to_s, 1e8));
  const auto within = [&](LogTime t) { return t >= from && t <= to; };
  std::vector<ImuSample> imu;
  NavTrajectory truth;
  for (const ImuSample& s : drive->recording.imu)
    if (within(s.time)) imu.push_back(s);
  std::vector<RangeEpoch> ranges;
  for (const RangeEpoch& e : drive->recording.ranges)
    if (within(e.time)) ranges.push_back(e);
  // Every tenth of a second: the reference is a smooth curve through what was recorded.
  const Eigen::Vector3d lever = -config->filter.antenna_lever_arm_m;
  if (!ranges.empty())
    for (LogTime t = ranges.front().time; t <= ranges.back().time;
         t += std::chrono::milliseconds(100))
      truth.push_back(
          examples::at_lever_arm(drive->antenna_truth(t), lever, Eigen::Vector3d::Zero()));
  if (imu.empty() || truth.empty())
    return Error{ErrorCode::invalid, "there is nothing between --from and --to"};
  examples::NavConfig cut;
  cut.filter = config->filter;
  cut.truth_is_antenna = false;
  // Level comes from no instrument: the reference's attitude is its course.
  cut.truth_is_true = false;
  cut.note = "cut from " + drive->name;
  const auto path = [&o](const char* name) {
    return (std::filesystem::path(o.out) / name).string();
  };
  if (auto done = io::write_imu(path("imu.txt"), imu, writing); !done) return done;
  if (auto done = io::write_ranges(path("ranges.txt"), ranges, writing); !done) return done;
  if (auto done = io::write_nav(path("truth.txt"), truth, writing); !done) return done;
  if (auto done = io::write_file(path("config.json"), examples::format_nav_config(cut), writing);
      !done)
    return done;
  std::printf("%s: %zu inertial readings, %zu range epochs\n", o.out.c_str(), imu.size(),
              ranges.size());
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  examples::CommandLine app(
      "Cut a stretch out of a recorded drive for tune: the unit's readings are real, the ranges "
      "simulated\nalong the recording's reference, whose attitude is the course.");
  Options o;
  app.add_option("--imu", o.files.imu, "inertial samples").required().existing_file();
  app.add_option("--imu-tags", o.files.imu_tags, "RTKLIB's time tags of the inertial file")
      .existing_file();
  app.add_option("--truth", o.files.truth, "the reference the ranges are simulated along")
      .required()
      .existing_file();
  app.add_option("--config", o.config, "JSON description of the recording; see gnss_ins")
      .existing_file();
  app.add_option("--from", o.from_s, "seconds after the first sample").show_default();
  app.add_option("--to", o.to_s, "seconds after the first sample");
  app.add_option("--seed", o.ranges.seed, "of the ranges").show_default();
  app.add_option("--satellites", o.ranges.satellites, "in view").show_default();
  examples::add_imu_topic(app, o.files.topics);
  app.add_option("--out", o.out, "folder for the results, made where needed").required();
  app.add_flag("--force", o.force, "replace files of an earlier run");
  if (const auto code = app.parse(argc, argv)) return *code;
  return examples::exit_code("cut_drive", run(o));
}
