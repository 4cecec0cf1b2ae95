#include "nav_drives.hpp"

#include <memory>
#include <vector>

#include <wayfare/core/random.hpp>
#include <wayfare/sim/gnss.hpp>
#include <wayfare/sim/vehicle_trajectory.hpp>

namespace wayfare::examples {
namespace {

// Separate random streams, so that ranges and readings are independent.
constexpr std::uint64_t kRangeStream = 1;
constexpr std::uint64_t kImuStream = 2;
constexpr std::uint64_t kWheelStream = 3;

std::vector<RangeEpoch> ranges_along(const sim::VehicleTrajectory& trajectory,
                                     const RangeSimulation& ranges,
                                     const ReceiverClockNoise& clock) {
  sim::RangeParams params;
  params.period = from_seconds(ranges.period_s);
  params.max_satellites = ranges.satellites;
  params.range_sigma_m = ranges.range_sigma_m;
  params.range_rate_sigma_mps = ranges.rate_sigma_mps;
  params.clock = clock;
  if (ranges.phases) params.phases.emplace();
  return sim::simulate_ranges(trajectory, sim::gps_and_galileo(), params,
                              Rng(ranges.seed).stream(kRangeStream))
      .epochs;
}

/// Along the antenna's path, as if the axle were below it.
std::vector<WheelSpeed> wheels_along(const sim::VehicleTrajectory& trajectory,
                                     const RangeSimulation& ranges) {
  if (!ranges.wheels) return {};
  return sim::simulate_wheel_speeds(trajectory, *ranges.wheels,
                                    Rng(ranges.seed).stream(kWheelStream))
      .readings;
}

std::function<NavState(LogTime)> truth_of(sim::VehicleTrajectory trajectory) {
  const auto shared = std::make_shared<const sim::VehicleTrajectory>(std::move(trajectory));
  return [shared](LogTime t) { return shared->state(t); };
}

/// Beyond the reference there is no truth.
void keep_within(std::vector<RangeEpoch>& ranges, const NavTrajectory& reference) {
  std::erase_if(ranges, [&](const RangeEpoch& epoch) {
    return epoch.time < reference.front().time || epoch.time > reference.back().time;
  });
}

}  // namespace

void add_recorded_ranges(CommandLine& app, NavFiles& files) {
  app.add_file("--obs", files.observations,
               "raw observations of the drive, RINEX 2.1 or 3, instead of simulated ranges");
  app.add_file("--nav", files.navigation, "broadcast messages, RINEX; several files allowed")
      .expected(1, 8);
  app.add_file("--ranges", files.ranges, "corrected ranges instead of --obs and --nav");
}

Result<KnownDrive> recorded_drive(const NavFiles& files, const NavConfig& config,
                                  const RangeSimulation& ranges) {
  const bool recorded = !files.observations.empty() || !files.ranges.empty();
  NavFiles measured = files;
  NavConfig described = config;
  if (!recorded) {
    // The loader needs satellite measurements: the reference serves as fixes.
    measured.fixes = files.truth;
    described.fixes = config.truth;
  }
  auto loaded = load_nav_recording(measured, described);
  if (!loaded) return loaded.error();
  auto trajectory = sim::follow_solution(loaded->truth.states);
  if (!trajectory) return trajectory.error();
  KnownDrive drive;
  drive.name = files.imu.front();
  drive.recording = std::move(loaded->recording);
  drive.recording.fixes.clear();
  drive.recorded_ranges = recorded;
  if (recorded) {
    keep_within(drive.recording.ranges, loaded->truth.states);
    if (drive.recording.ranges.empty())
      return Error{ErrorCode::not_found, "there are no ranges within the time of the reference",
                   files.truth};
  } else {
    drive.recording.ranges = ranges_along(*trajectory, ranges, config.filter.clock);
  }
  drive.recording.wheels = wheels_along(*trajectory, ranges);
  drive.options = config.filter;
  drive.antenna_truth = truth_of(std::move(*trajectory));
  drive.remarks = std::move(loaded->remarks);
  return drive;
}

KnownDrive simulated_drive(const RangeSimulation& ranges) {
  sim::VehicleTrajectory trajectory = sim::demo_drive();
  KnownDrive drive;
  drive.name = "simulated drive";
  sim::ImuParams unit;
  unit.noise = drive.options.imu;
  Rng rng = Rng(ranges.seed).stream(kImuStream);
  drive.recording.imu = sim::simulate_imu(trajectory, unit, rng).samples;
  drive.recording.ranges = ranges_along(trajectory, ranges, drive.options.clock);
  drive.recording.wheels = wheels_along(trajectory, ranges);
  drive.antenna_truth = truth_of(std::move(trajectory));
  drive.attitude_known = true;
  return drive;
}

}  // namespace wayfare::examples
