// EXPECT: localiser.add_motion
#include <optional>

#include <wayfare/slam/run_localisation.hpp>

struct Nowhere {
  using Odometry = std::optional<wayfare::Transform2<wayfare::frame::Odom, wayfare::frame::Base>>;
#ifndef WAYFARE_MUST_FAIL
  wayfare::Result<void> add_motion(wayfare::LogTime, const Odometry&) { return {}; }
#endif
  wayfare::Result<wayfare::MonteCarloOutcome<wayfare::SE2d>> add_scan(wayfare::LogTime time,
                                                                      const wayfare::LaserScan&,
                                                                      const Odometry&) {
    return wayfare::MonteCarloOutcome<wayfare::SE2d>{.time = time};
  }
};

bool run(Nowhere& localiser) {
  return wayfare::run_localisation(wayfare::Recording{}, localiser).has_value();
}
