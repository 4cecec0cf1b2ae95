#include "walks.hpp"

#include <cmath>
#include <filesystem>
#include <system_error>

#include <wayfare/estimate/pedestrian.hpp>
#include <wayfare/io/carmen_writer.hpp>
#include <wayfare/io/marg_text.hpp>
#include <wayfare/sim/head_walk.hpp>
#include <wayfare/system/hector_slam.hpp>
#include <wayfare/system/pedestrian_slam.hpp>

namespace wayfare::examples {
namespace {

constexpr double kUnitRate_hz = 100.0, kScanRate_hz = 5.5, kFirstScan_s = 1.0;

struct Recorded {
  MargRecording unit;
  std::vector<LaserScan> scans;
  Trajectory truth;  // of the levelled unit, at the scans' times
};

Recorded record(const Walk& walk, const sim::HeadWalk& head, Rng& rng) {
  Recorded r;
  r.unit = head.unit(kUnitRate_hz, {}, rng);
  for (double t = kFirstScan_s; t < head.lasts_s() - 0.1; t += 1 / kScanRate_hz) {
    const auto time = LogTime::from_seconds(t);
    const auto pose = head.at(t);
    r.scans.push_back(sim::scan_from_head(walk.plan, pose, time, {}, rng));
    const Eigen::Vector3d x = pose.q_world_head * Eigen::Vector3d::UnitX();
    r.truth.push_back({time, Transform2<frame::Map, frame::Base>(
                                 SE2d(pose.position_m.x(), pose.position_m.y(),
                                      Angle::radians(std::atan2(x.y(), x.x()))))});
  }
  return r;
}

PedestrianParameters pedestrian(double step_m) {
  PedestrianParameters p;
  p.forward = Eigen::Vector3d::UnitX();
  p.length = ConstantStep{step_m};
  p.ahrs.use_magnetometer = false;
  return p;
}

/// The length of a known way over the steps it took.
double calibrated_step_m(const sim::HeadWalkParams& walker, Rng rng) {
  const sim::HeadWalk head(calibration_route(), walker, rng.stream(1));
  Pedestrian steps(pedestrian(1.0));
  for (const MargSample& s : head.unit(kUnitRate_hz, {}, rng)) steps.add(s);
  return head.way_m() / steps.report().walked_m;
}

double rmse_m(const Trajectory& estimate, const Trajectory& truth) {
  const SE2d start = truth[0].T_map_base.raw() * estimate[0].T_map_base.raw().inverse();
  double sum = 0.0;
  for (std::size_t i = 0; i < truth.size(); ++i)
    sum += ((start * estimate[i].T_map_base.raw()).translation() -
            truth[i].T_map_base.raw().translation())
               .squaredNorm();
  return std::sqrt(sum / static_cast<double>(truth.size()));
}

struct Followed {
  Trajectory slam, steps;
  std::vector<LaserScan> levelled;
  double scale;
};

Followed follow(const Recorded& recorded, const PedestrianSlamOptions& options) {
  PedestrianSlam slam(options);
  Followed result;
  auto reading = recorded.unit.begin();
  for (const LaserScan& scan : recorded.scans) {
    for (; reading != recorded.unit.end() && reading->time <= scan.time; ++reading)
      slam.add(*reading);
    if (!slam.add_scan(scan)) continue;
    result.levelled.push_back(slam.levelled());
  }
  (void)slam.finish();
  result.slam = slam.slam().trajectory();
  result.steps = slam.dead_reckoning();
  result.scale = slam.feedback().scale();
  return result;
}

Trajectory follow_by_hector(const std::vector<LaserScan>& levelled) {
  HectorSlam hector;
  for (const LaserScan& scan : levelled) (void)hector.add_scan(scan, std::nullopt);
  return hector.trajectory();
}

struct Simulated {
  Recorded recorded;
  double step_m;  // as calibrated
  double way_m;
};

Simulated simulate(const Walk& walk, std::uint64_t seed) {
  Rng rng = Rng(seed).stream(7);
  sim::HeadWalkParams walker;
  walker.step_m *= 1 + 0.05 * rng.normal();
  const double step_m = calibrated_step_m(walker, rng.stream(2));
  walker.step_m *= 1 + 0.03 * rng.normal();  // nobody's stride is that of the day of calibration
  const sim::HeadWalk head(walk.route_m, walker, rng.stream(3));
  return {record(walk, head, rng), step_m, head.way_m()};
}

}  // namespace

const std::vector<std::string>& methods() {
  static const std::vector<std::string> names = {"steps", "Hector", "submaps", "submaps + steps",
                                                 "submaps + steps, fed back"};
  return names;
}

WalkErrors follow_walk(const Walk& walk, std::uint64_t seed) {
  const Simulated simulated = simulate(walk, seed);
  const Recorded& recorded = simulated.recorded;
  PedestrianSlamOptions options;
  options.pedestrian = pedestrian(simulated.step_m);
  options.feedback = false;
  const Followed with_steps = follow(recorded, options);
  options.steps = false;
  const Followed alone = follow(recorded, options);
  options.steps = options.feedback = true;
  const Followed fed_back = follow(recorded, options);
  WalkErrors errors{simulated.way_m, {}, fed_back.scale};
  for (const Trajectory& t : {with_steps.steps, follow_by_hector(with_steps.levelled), alone.slam,
                              with_steps.slam, fed_back.slam})
    errors.rmse_m.push_back(rmse_m(t, recorded.truth));
  return errors;
}

Result<void> write_walk(const Walk& walk, std::uint64_t seed, const std::string& folder) {
  const Simulated simulated = simulate(walk, seed);
  Recording recording;
  recording.scans = simulated.recorded.scans;
  recording.truth = simulated.recorded.truth;
  const io::WriteOptions replace{io::Existing::replace};
  std::error_code code;
  std::filesystem::create_directories(folder, code);  // where it cannot be, writing says so
  if (auto ok = io::write_carmen(folder + "/walk.log", recording, replace); !ok) return ok;
  return io::write_marg(folder + "/unit.csv", simulated.recorded.unit, replace);
}

}  // namespace wayfare::examples
