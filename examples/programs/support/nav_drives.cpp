#include "nav_drives.hpp"

#include <memory>

#include <wayfare/core/random.hpp>
#include <wayfare/sim/gnss.hpp>
#include <wayfare/sim/vehicle_trajectory.hpp>

namespace wayfare::examples {
namespace {

// Separate random streams, so that ranges and readings are independent.
constexpr std::uint64_t kRangeStream = 1;
constexpr std::uint64_t kImuStream = 2;

std::vector<RangeEpoch> ranges_along(const sim::VehicleTrajectory& trajectory,
                                     const RangeSimulation& ranges,
                                     const ReceiverClockNoise& clock) {
  sim::RangeParams params;
  params.period = from_seconds(ranges.period_s);
  params.max_satellites = ranges.satellites;
  params.range_sigma_m = ranges.range_sigma_m;
  params.range_rate_sigma_mps = ranges.rate_sigma_mps;
  params.clock = clock;
  return sim::simulate_ranges(trajectory, sim::gps_and_galileo(), params,
                              Rng(ranges.seed).stream(kRangeStream))
      .epochs;
}

std::function<NavState(LogTime)> truth_of(sim::VehicleTrajectory trajectory) {
  const auto shared = std::make_shared<const sim::VehicleTrajectory>(std::move(trajectory));
  return [shared](LogTime t) { return shared->state(t); };
}

}  // namespace

Result<KnownDrive> recorded_drive(const NavFiles& files, const NavConfig& config,
                                  const RangeSimulation& ranges) {
  // The loader needs satellite measurements: the reference serves as fixes.
  NavFiles with_fixes = files;
  with_fixes.fixes = files.truth;
  NavConfig described = config;
  described.fixes = config.truth;
  auto loaded = load_nav_recording(with_fixes, described);
  if (!loaded) return loaded.error();
  auto trajectory = sim::follow_solution(loaded->truth.states);
  if (!trajectory) return trajectory.error();
  KnownDrive drive;
  drive.name = files.imu.front();
  drive.recording = std::move(loaded->recording);
  drive.recording.fixes.clear();
  drive.recording.ranges = ranges_along(*trajectory, ranges, config.filter.clock);
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
  drive.antenna_truth = truth_of(std::move(trajectory));
  drive.attitude_known = true;
  return drive;
}

}  // namespace wayfare::examples
