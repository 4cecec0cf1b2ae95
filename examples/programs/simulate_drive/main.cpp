// Simulates the inertial unit and satellite receiver of a car in streets or along a recorded track.

#include <cstdio>
#include <span>
#include <string>
#include <vector>

#include <wayfare/io/nav_text.hpp>
#include <wayfare/sim/gnss.hpp>
#include <wayfare/sim/vehicle_trajectory.hpp>

#include "support/nav_config.hpp"
#include "support/program_files.hpp"
#include "support/track_files.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

struct Options : OutputArguments {
  std::string track, config;
  std::string route = "demo";
  double velocity_late_s = 0.0;
  std::uint64_t seed = 1;
  double imu_rate_hz = 100.0, range_rate_hz = 1.0, elevation_mask_deg = 10.0;
  double multipath_per_hour = 0.0;
  std::size_t satellites = 64;
  std::vector<double> lever_arm_m = {0.0, 0.0, 0.0};
  std::vector<std::string> outages;
  TrackFormats formats;
  double start_s = 0.0;
  bool perfect_unit = false, wheels = false, phases = false;
  double slips_per_hour = 0.0, cycle_slips_per_hour = 0.0;
  std::vector<double> axle_m = {0.0, 0.0, 0.0};
  sim::WheelSpeedParams wheel;
  sim::ImuParams imu;
  sim::RangeParams ranges;
};

void add_options(CommandLine& app, Options& o) {
  add_out(app, o, "folder for imu.txt, ranges.txt, truth.txt and wheels.txt");
  app.add_option("--track", o.track,
                 "follow this recorded solution (navigation text, RTKLIB's .pos, GPX, NMEA or UBX) "
                 "instead of the "
                 "built-in drive of 310 s and 4.5 km");
  app.add_option("--route", o.route,
                 "which built-in drive: demo (310 s, 4.5 km), town (many turns), ring (fast)")
      .one_of({"demo", "town", "ring"})
      .show_default();
  app.add_file("--config", o.config,
               "true noise of the unit and of the receiver's clock: imu_noise and filter of a "
               "description for gnss_ins");
  app.add_option("--velocity-late", o.velocity_late_s,
                 "delay of the time stamps of the track's velocities, s")
      .show_default();
  app.add_option("--seed", o.seed, kSeedHelp).show_default();
  app.add_number("--start", o.start_s, 0.0, 4e9,
                 "of the built-in drive: seconds of GPS time since 1980-01-06");
  o.formats.add_option(app);
  add_force_and_quiet(app, o);
}

void add_wheel_options(CommandLine& app, Options& o) {
  app.add_flag("--wheels", o.wheels, "with the speeds of wheels, ten a second: wheels.txt");
  app.add_number("--wheel-scale", o.wheel.scale, -0.5, 0.5, "relative error of the wheels' speed");
  app.add_number("--wheel-sigma", o.wheel.sigma_mps, 0.0, 100.0, "noise of their speed, m/s");
  app.add_number("--wheel-resolution", o.wheel.resolution_mps, 0.0, 100.0,
                 "their speed is a multiple of this, m/s; 0: any number");
  app.add_number("--wheel-slips", o.slips_per_hour, 0.0, 3600.0,
                 "how often an hour they spin or lock, for 1 s and by 20 % on average");
  app.add_option("--axle", o.axle_m, "from the unit to the axle: forward, right, down, m")
      .expected(3);
  app.add_flag("--phases", o.phases, "with carrier phases, with 3 mm of noise: ranges.txt");
  app.add_number("--cycle-slips", o.cycle_slips_per_hour, 0.0, 3600.0,
                 "slips of each satellite's phase an hour, half of them noticed by the receiver");
}

void add_sensor_options(CommandLine& app, Options& o) {
  app.add_number("--imu-rate", o.imu_rate_hz, 1.0, 10000.0,
                 "samples per second of the inertial unit");
  app.add_flag("--perfect-imu", o.perfect_unit, "an inertial unit without errors");
  app.add_number("--range-rate", o.range_rate_hz, 0.01, 100.0, "epochs per second of the receiver");
  app.add_number("--satellites", o.satellites, 1, 64,
                 "largest number of satellites, chosen for their geometry");
  app.add_number("--mask", o.elevation_mask_deg, -10.0, 90.0, "smallest elevation, degrees");
  app.add_number("--range-sigma", o.ranges.range_sigma_m, 0.0, 1000.0, "noise of a range, m");
  app.add_number("--rate-sigma", o.ranges.range_rate_sigma_mps, 0.0, 1000.0,
                 "noise of a range rate, m/s");
  app.add_number("--multipath", o.multipath_per_hour, 0.0, 3600.0,
                 "bursts of reflections per satellite and hour, 20 m and 10 s on average");
  app.add_option("--outage", o.outages,
                 "BEGIN:LENGTH[:SATELLITES], seconds since the start, and the number left (0)")
      .take_all();
  app.add_option("--lever-arm", o.lever_arm_m,
                 "from the unit to the antenna: forward, right, down, m")
      .expected(3);
}

sim::VehicleTrajectory built_in(const Options& o) {
  const LogTime start = LogTime::from_seconds(o.start_s);
  if (o.route == "demo") return sim::demo_drive(start);
  constexpr sim::Waypoint kTown[] = {{0, 0, 0, 6},     {0, 250, 2, 0},   {180, 250, 3, 5},
                                     {180, 480, 1, 0}, {420, 480, 0, 0}, {420, 120, 4, 6},
                                     {650, 120, 6, 0}, {650, 520, 2, 0}, {900, 520, 0, 3}};
  constexpr sim::Waypoint kRing[] = {{0, 0, 0, 6},      {-400, 300, 5, 0}, {-300, 900, 12, 0},
                                     {250, 1150, 8, 0}, {800, 900, 3, 5},  {750, 350, 0, 3}};
  sim::VehicleLimits limits;
  limits.speed_mps = o.route == "town" ? 14.0 : 25.0;
  const std::span<const sim::Waypoint> route =
      o.route == "town" ? std::span<const sim::Waypoint>(kTown) : kRing;
  const Geodetic origin{Angle::degrees(51.0797), Angle::degrees(-114.1314), 1100.0};
  return sim::drive_waypoints(origin, route, limits, start).value();
}

Result<sim::VehicleTrajectory> load_trajectory(const Options& o) {
  if (o.track.empty()) return built_in(o);
  const auto track = io::read_nav(o.track);
  if (!track) return track.error();
  sim::TrackFit fit;
  fit.velocity_late_s = o.velocity_late_s;
  fit.attitude_from_course = !track->has_attitude;
  if (!track->has_velocity) fit.velocity_sigma_mps = 1e6;
  auto followed = sim::follow_solution(track->trajectory, fit);
  if (!followed) return Error{followed.error().code, followed.error().message, o.track};
  return followed;
}

Result<sim::SatelliteOutage> parse_outage(const std::string& text,
                                          const sim::VehicleTrajectory& trajectory) {
  const auto outages = parse_outages(text);
  if (!outages || outages->size() != 1 ||
      outages->front().start_s + outages->front().length_s > 1e7)
    return bad_use("--outage must be BEGIN:LENGTH[:SATELLITES], not '" + text + "'");
  if (auto ok = check_outages(*outages, to_seconds(trajectory.end() - trajectory.begin())); !ok)
    return ok.error();
  const NavOutage& o = outages->front();
  const LogTime from = trajectory.begin() + from_seconds(o.start_s);
  return sim::SatelliteOutage{from, from + from_seconds(o.length_s), o.satellites_left};
}

Result<void> complete(Options& o, const sim::VehicleTrajectory& trajectory) {
  if (!o.config.empty()) {
    const auto config = read_nav_config(o.config);
    if (!config) return config.error();
    o.imu.noise = config->filter.imu;
    o.ranges.clock = config->filter.clock;
  }
  o.wheel.slips_per_hour = o.slips_per_hour;
  o.wheel.lever_arm_m = {o.axle_m[0], o.axle_m[1], o.axle_m[2]};
  if (o.phases) o.ranges.phases.emplace().slips_per_satellite_hour = o.cycle_slips_per_hour;
  o.imu.period = from_seconds(1.0 / o.imu_rate_hz);
  if (o.perfect_unit) o.imu.noise = sim::perfect_imu();
  o.ranges.period = from_seconds(1.0 / o.range_rate_hz);
  o.ranges.elevation_mask = Angle::degrees(o.elevation_mask_deg);
  o.ranges.max_satellites = o.satellites;
  o.ranges.multipath.per_satellite_hour = o.multipath_per_hour;
  o.ranges.antenna_lever_arm_m = {o.lever_arm_m[0], o.lever_arm_m[1], o.lever_arm_m[2]};
  for (const std::string& text : o.outages) {
    auto outage = parse_outage(text, trajectory);
    if (!outage) return outage.error();
    o.ranges.outages.push_back(*outage);
  }
  return {};
}

Result<void> write_wheels(const sim::VehicleTrajectory& trajectory, const Options& o,
                          const Rng& rng) {
  const auto wheels = sim::simulate_wheel_speeds(trajectory, o.wheel, rng);
  return io::write_wheels(o.path("wheels.txt"), wheels.readings, o.write());
}

Result<void> run(Options& o) {
  std::vector<std::string> files = {"imu.txt", "ranges.txt", "truth.txt"};
  if (o.wheels) files.emplace_back("wheels.txt");
  if (auto ready = o.prepare(o.formats.with_files(files)); !ready) return ready;
  const auto trajectory = load_trajectory(o);
  if (!trajectory) return trajectory.error();
  if (auto ok = complete(o, *trajectory); !ok) return ok;
  const Rng rng(o.seed);
  const sim::SimulatedImu imu = sim::simulate_imu(*trajectory, o.imu, rng.stream(0));
  const sim::SimulatedRanges ranges =
      sim::simulate_ranges(*trajectory, sim::gps_and_galileo(), o.ranges, rng.stream(1));
  NavTrajectory truth;
  for (const ImuSample& s : imu.samples) truth.push_back(trajectory->state(s.time));
  const auto done =
      first_error({io::write_imu(o.path("imu.txt"), imu.samples, o.write()),
                   io::write_ranges(o.path("ranges.txt"), ranges.epochs, o.write()),
                   io::write_nav(o.path("truth.txt"), truth, o.write()),
                   o.wheels ? write_wheels(*trajectory, o, rng.stream(2)) : Result<void>{},
                   write_track_files(o, o.formats, truth)});
  if (done && !o.quiet)
    std::printf("%s: %zu inertial readings, %zu range epochs, %.1f s\n", o.out.c_str(),
                imu.samples.size(), ranges.epochs.size(),
                to_seconds(trajectory->end() - trajectory->begin()));
  return done;
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine app("Simulate a car with an inertial unit and a satellite receiver.");
  Options options;
  add_options(app, options);
  add_sensor_options(app, options);
  add_wheel_options(app, options);
  app.example("--out drive", "a drive of 310 s");
  app.example("--route town --outage 60:20 --out drive",
              "a drive in a town without satellites from 60 s to 80 s");
  if (const auto code = app.parse(argc, argv)) return *code;
  return exit_code("simulate_drive", run(options));
}
