#include "walks.hpp"

#include <wayfare/slam/hector_slam.hpp>
#include <wayfare/slam/pedestrian_slam.hpp>

#include "recorded_walk.hpp"

namespace wayfare::examples {
namespace {

struct Followed {
  Trajectory slam, steps;
  std::vector<LaserScan> levelled;
  double scale;
};

Followed follow(const RecordedWalk& recorded, const PedestrianSlamOptions& options) {
  PedestrianSlam slam(options);
  Followed result;
  auto reading = recorded.unit.begin();
  for (const LaserScan& scan : recorded.scans) {
    for (; reading != recorded.unit.end() && reading->time <= scan.end_time(); ++reading)
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

}  // namespace

const std::vector<std::string>& methods() {
  static const std::vector<std::string> names = {"steps", "Hector", "submaps", "submaps + steps",
                                                 "submaps + steps, fed back"};
  return names;
}

WalkErrors follow_walk(const Walk& walk, std::uint64_t seed) {
  const SimulatedWalk simulated = simulate_walk(walk, seed);
  const RecordedWalk& recorded = simulated.recorded;
  PedestrianSlamOptions options;
  options.pedestrian = head_pedestrian(simulated.step_m);
  options.feedback = false;
  const Followed with_steps = follow(recorded, options);
  options.steps = false;
  const Followed alone = follow(recorded, options);
  options.steps = options.feedback = true;
  const Followed fed_back = follow(recorded, options);
  WalkErrors errors{simulated.head.path_length_m(), {}, fed_back.scale};
  for (const Trajectory& t : {with_steps.steps, follow_by_hector(with_steps.levelled), alone.slam,
                              with_steps.slam, fed_back.slam})
    errors.rmse_m.push_back(rmse_m(t, recorded.truth));
  return errors;
}

}  // namespace wayfare::examples
