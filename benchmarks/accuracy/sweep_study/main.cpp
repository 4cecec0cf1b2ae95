// A robot whose LiDAR measures the beams of a scan one after the other, in simulated worlds: errors
// of the systems with instantaneous scans, with sweeps taken as instantaneous, and with sweeps.

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

#include <wayfare/core/statistics.hpp>
#include <wayfare/eval/table.hpp>
#include <wayfare/sim/simulate_recording.hpp>

#include "support/program_files.hpp"
#include "support/progress_line.hpp"
#include "systems.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

struct Options {
  int seeds = 5;
  std::uint64_t first = 1;
  double speed_m_s = 1.0, turn_deg_s = 90.0, sweep_ms = 181.3, rate_hz = 5.5;
  std::string only;
  bool each = false, quiet = false;
};

enum Kind : std::size_t { kInstant, kUncorrected, kCorrected, kKinds };

/// The Turtlebot's wheels and gyro, faster, with an RPLIDAR.
sim::RobotParams robot_of(const Options& o, const Rng& rng) {
  sim::RobotParams robot = sim::turtlebot(rng).robot;
  robot.drive.max_speed_m_s = o.speed_m_s;
  robot.drive.max_turn_rate_rad_s = Angle::degrees(o.turn_deg_s).radians();
  robot.drive.max_acceleration_m_s2 = 1.0;
  robot.lidar.max_range_m = 12.0;
  robot.scan_period = from_seconds(1.0 / o.rate_hz);
  return robot;
}

Result<Drive> drive_through(const sim::World& world, sim::RobotParams robot, const Rng& rng) {
  robot.wheels.carpets = world.carpets;
  auto run = sim::simulate_recording(world.plan, world.route_m, robot, rng);
  if (!run) return run.error();
  Drive drive{std::move(run->recording), &world};
  drive.recording.wheel_base_m = robot.wheels.wheel_base_m;
  drive.recording.wheels = std::move(run->wheels);
  drive.recording.gyro = std::move(run->gyro);
  drive.recording.truth = std::move(run->truth);
  return drive;
}

/// The same drive, measured in each way.
Result<std::array<Drive, kKinds>> drives_of(const sim::World& world, const Options& o,
                                            const Rng& rng) {
  sim::RobotParams robot = robot_of(o, rng);
  auto instant = drive_through(world, robot, rng);
  if (!instant) return instant.error();
  robot.lidar.sweep = from_seconds(1e-3 * o.sweep_ms);
  auto sweeps = drive_through(world, robot, rng);
  if (!sweeps) return sweeps.error();
  Drive uncorrected = *sweeps;
  for (LaserScan& scan : uncorrected.recording.scans) scan.time_increment = Duration::zero();
  return std::array<Drive, kKinds>{*std::move(instant), std::move(uncorrected), *std::move(sweeps)};
}

class Study {
 public:
  explicit Study(const Options& o) : o_(o) {
    for (System& system : scan_systems())
      if (system.name.find(o.only) != std::string::npos) systems_.push_back(std::move(system));
  }

  Result<void> add(const std::string& name) {
    errors_.assign(systems_.size(), {});
    ProgressLine progress(name, o_.quiet);
    for (int k = 0; k < o_.seeds; ++k) {
      const std::uint64_t seed = o_.first + static_cast<std::uint64_t>(k);
      const Rng rng(seed);
      const auto world = sim::make_world(name, rng);
      if (!world) return world.error();
      const auto drives = drives_of(*world, o_, rng);
      if (!drives) return drives.error();
      for (std::size_t s = 0; s < systems_.size(); ++s) {
        if (auto ok = follow(s, *drives, seed); !ok) return ok;
        progress.update((k + static_cast<double>(s + 1) / static_cast<double>(systems_.size())) /
                        o_.seeds);
      }
    }
    progress.finish();
    add_rows(name);
    return {};
  }

  [[nodiscard]] std::string text() const { return table_.to_text(); }

 private:
  Result<void> follow(std::size_t s, const std::array<Drive, kKinds>& drives, std::uint64_t seed) {
    if (o_.each) std::printf("%s, seed %d:", systems_[s].name.c_str(), static_cast<int>(seed));
    for (std::size_t kind = 0; kind < kKinds; ++kind) {
      const Drive& drive = drives[kind];
      const auto found = systems_[s].run(drive, seed);
      if (!found) return found.error();
      const auto error =
          eval::absolute_error(*found, drive.recording.truth, {systems_[s].alignment});
      errors_[s][kind].push_back(error.translation_m.rmse);
      if (o_.each) std::printf(" %.3f", error.translation_m.rmse);
    }
    if (o_.each) std::printf("\n");
    return {};
  }

  void add_rows(const std::string& world) {
    for (std::size_t s = 0; s < systems_.size(); ++s) {
      std::array<Summary, kKinds> of;
      for (std::size_t kind = 0; kind < kKinds; ++kind) of[kind] = summarise(errors_[s][kind]);
      std::vector<std::string> row{world, systems_[s].name};
      for (const Summary& summary : of) {
        row.push_back(eval::fixed(summary.mean, 3));
        row.push_back(eval::fixed(summary.max, 3));
      }
      row.push_back(eval::fixed(of[kCorrected].mean / of[kInstant].mean, 2));
      table_.add_row(row);
    }
  }

  const Options& o_;
  std::vector<System> systems_;
  std::vector<std::array<std::vector<double>, kKinds>> errors_;  // of each system
  eval::Table table_{{{"world"},
                      {"system"},
                      {"instantaneous", "m"},
                      {"worst", "m"},
                      {"sweeps as they are", "m"},
                      {"worst", "m"},
                      {"sweeps undone", "m"},
                      {"worst", "m"},
                      {"ratio"}}};
};

Result<void> run(const Options& o) {
  Study study(o);
  for (const sim::WorldName& world : sim::world_names())
    if (auto ok = study.add(std::string(world.name)); !ok) return ok;
  std::fputs(study.text().c_str(), stdout);
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine app(
      "Errors of the systems that process scans where a LiDAR takes a sixth of a second to turn: "
      "root mean squares of the position over a drive, mean and worst of the seeds.");
  Options o;
  app.add_option("--seeds", o.seeds, "drives per world").positive();
  app.add_option("--seed", o.first, "of the random numbers, for the first drive");
  app.add_number("--speed", o.speed_m_s, 0.1, 5.0, "the robot's largest, m/s");
  app.add_number("--turn-rate", o.turn_deg_s, 5.0, 360.0, "the robot's largest, deg/s");
  app.add_number("--rate", o.rate_hz, 0.5, 50.0, "revolutions of the LiDAR per second");
  app.add_number("--sweep", o.sweep_ms, 0.0, 2000.0,
                 "time from a scan's first beam to its last, ms");
  app.add_option("--only", o.only, "the systems with this in their name");
  app.add_flag("--each", o.each, "print every drive");
  app.add_flag("--quiet", o.quiet, kQuietHelp);
  app.example("--seeds 5", "five drives in each world");
  if (const auto code = app.parse(argc, argv)) return *code;
  return exit_code("sweep_study", run(o));
}
