#include "recorded_walk.hpp"

#include <cmath>
#include <filesystem>
#include <system_error>

#include <wayfare/eval/table.hpp>
#include <wayfare/io/carmen.hpp>
#include <wayfare/io/nav_text.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/pedestrian/pedestrian.hpp>

namespace wayfare::examples {
namespace {

constexpr double kUnitRate_hz = 100.0, kScanRate_hz = 5.5, kFirstScan_s = 1.0;

SE2d levelled(const sim::HeadWalk::Pose& pose) {
  const Eigen::Vector3d x = pose.q_world_head * Eigen::Vector3d::UnitX();
  return SE2d(pose.position_m.x(), pose.position_m.y(), Angle::radians(std::atan2(x.y(), x.x())));
}

LaserScan scan_at(const Walk& walk, const sim::HeadWalk& head, double t, Rng& rng) {
  const auto time = LogTime::from_seconds(t);
  if (walk.sweep == Duration::zero())
    return sim::scan_from_head(walk.plan, head.at(t), time, {}, rng);
  sim::HeadLidarParams lidar;
  lidar.sweep = walk.sweep;
  LaserScan scan = sim::sweep_from_head(walk.plan, head, time, lidar, rng);
  if (!walk.beams_have_times) scan.time_increment = Duration::zero();
  return scan;
}

RecordedWalk record(const Walk& walk, const sim::HeadWalk& head,
                    const sim::HeadWalk::UnitNoise& noise, Rng& rng) {
  RecordedWalk r;
  r.unit = head.unit(kUnitRate_hz, noise, rng);
  for (double t = kFirstScan_s; t < head.duration_s() - 0.1; t += 1 / kScanRate_hz) {
    r.scans.push_back(scan_at(walk, head, t, rng));
    r.truth.push_back(
        {r.scans.back().time, Transform2<frame::Map, frame::Base>(levelled(head.at(t)))});
  }
  return r;
}

/// The length of a known path over the number of steps.
double calibrated_step_m(const sim::HeadWalkParams& walker, Rng rng) {
  const sim::HeadWalk head(calibration_route(), walker, rng.stream(1));
  Pedestrian steps(head_pedestrian(1.0));
  for (const MargSample& s : head.unit(kUnitRate_hz, {}, rng)) steps.add(s);
  return head.path_length_m() / steps.report().distance_m;
}

}  // namespace

PedestrianParameters head_pedestrian(double step_m) {
  PedestrianParameters p;
  p.forward = Eigen::Vector3d::UnitX();
  p.length = ConstantStep{step_m};
  p.ahrs.use_magnetometer = false;
  return p;
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

StampedPose SimulatedWalk::truth_at(LogTime time) const {
  return {time, Transform2<frame::Map, frame::Base>(levelled(head.at(time.seconds())))};
}

SimulatedWalk simulate_walk(const Walk& walk, std::uint64_t seed,
                            const sim::HeadWalk::UnitNoise& noise) {
  Rng rng = Rng(seed).stream(7);
  sim::HeadWalkParams walker;
  walker.step_m *= 1 + 0.05 * rng.normal();
  const double step_m = calibrated_step_m(walker, rng.stream(2));
  walker.step_m *= 1 + 0.03 * rng.normal();  // the step length differs from that at calibration
  const sim::HeadWalk head(walk.route_m, walker, rng.stream(3));
  return {head, record(walk, head, noise, rng), step_m};
}

Result<void> write_walk(const Walk& walk, std::uint64_t seed, const std::string& folder) {
  const SimulatedWalk simulated = simulate_walk(walk, seed);
  Recording recording;
  recording.scans = simulated.recorded.scans;
  recording.truth = simulated.recorded.truth;
  const io::WriteOptions replace{io::Existing::replace};
  std::error_code code;
  std::filesystem::create_directories(folder, code);  // a failure shows in writing
  if (auto ok = io::write_carmen(folder + "/walk.log", recording, replace); !ok) return ok;
  return io::write_marg(folder + "/unit.csv", simulated.recorded.unit, replace);
}

Result<void> write_plan(const sim::FloorPlan& plan, const std::string& path) {
  std::string text;
  for (const sim::Segment& s : plan.segments()) {
    text += "wall";
    for (const double v : {s.a_m.x(), s.a_m.y(), s.b_m.x(), s.b_m.y()})
      text += ' ' + eval::fixed(v, 3);
    text += '\n';
  }
  return io::write_file(path, text, {io::Existing::replace});
}

}  // namespace wayfare::examples
