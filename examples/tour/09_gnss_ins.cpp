// Inertial navigation with satellite ranges in ten calls: a drive through a town is simulated, and
// the 23-state filter follows it, at last without satellites.
#include <cmath>
#include <cstdio>

#include <wayfare/eval/nav_error.hpp>
#include <wayfare/nav/gnss_ins.hpp>
#include <wayfare/sim/gnss.hpp>
#include <wayfare/sim/vehicle_trajectory.hpp>

using namespace wayfare;

int main() {
  const sim::VehicleTrajectory drive = sim::demo_drive();
  const LogTime tunnel = drive.begin() + from_seconds(200.0);  // from here on no satellites
  const LogTime end = tunnel + from_seconds(20.0);
  sim::RangeParams receiver;
  receiver.outages = {{tunnel, drive.end(), 0}};
  const Rng rng(1);
  const auto unit = sim::simulate_imu(drive, {}, rng.stream(0));
  const auto ranges = sim::simulate_ranges(drive, sim::gps_and_galileo(), receiver, rng.stream(1));

  GnssIns filter{GnssInsOptions{}};
  double squares = 0.0;
  std::size_t next = 0, count = 0;
  for (const ImuSample& sample : unit.samples) {
    if (sample.time > end) break;
    if (const auto added = filter.add(sample); !added)
      return std::puts(added.error().message.c_str()), 1;
    for (; next < ranges.epochs.size() && ranges.epochs[next].time <= sample.time; ++next)
      (void)filter.add(ranges.epochs[next]);  // without satellites an Error: nothing to use
    if (!filter.started() || sample.time > tunnel) continue;  // starts from the satellites' speed
    const NavState truth = drive.state(sample.time);
    squares += eval::nav_error(filter.point().nav, truth).position_ned_m.squaredNorm();
    ++count;
  }

  const GnssInsEstimate estimate = filter.estimate();
  const auto error = eval::nav_error(estimate.nav, drive.state(estimate.nav.time));
  std::printf("with satellites: %.1f m rms\n", std::sqrt(squares / static_cast<double>(count)));
  std::printf("20 s without: %.1f m off, sigma %.1f m\n", error.position_ned_m.norm(),
              std::sqrt(estimate.covariance.topLeftCorner<3, 3>().trace()));
}
