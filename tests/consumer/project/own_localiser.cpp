#include "links.hpp"

#include <cmath>
#include <memory>

#include <wayfare/slam/basic_localiser.hpp>
#include <wayfare/slam/run_localisation.hpp>

// A likelihood, a map and a model of odometry of one's own: a cart on a floor whose brightness
// changes from place to place is found anywhere on it.
namespace {

struct Floor {
  static double brightness(const Eigen::Vector2d& p) {
    return std::sin(0.9 * p.x()) + std::cos(0.7 * p.y() + 0.2 * p.x());
  }
  wayfare::SE2d random_pose(wayfare::Rng& rng) const {
    return {rng.uniform(0.0, 8.0), rng.uniform(0.0, 5.0),
            wayfare::Angle::radians(rng.uniform(-3.14159, 3.14159))};
  }
};

struct LightSensors {
  Eigen::Vector3d read;
  static Eigen::Vector3d at(const wayfare::SE2d& pose) {
    return {Floor::brightness(pose.translation()), Floor::brightness(pose * Eigen::Vector2d(1, 0)),
            Floor::brightness(pose * Eigen::Vector2d(0, 1))};
  }
};

struct Light {
  double log_likelihood(const wayfare::SE2d& pose, const LightSensors& scan, const Floor&) const {
    return -0.5 * (LightSensors::at(pose) - scan.read).squaredNorm() / 0.01;
  }
};

struct Wheels {
  wayfare::Gaussian<wayfare::SE2d> motion(const wayfare::SE2d& increment) const {
    return {increment, Eigen::Vector3d(1e-4, 1e-4, 1e-4).asDiagonal()};
  }
};

/// The walls at both ends of a corridor, of which a laser sees how far they are.
struct Corridor {
  double length_m = 12.0;
  wayfare::SE2d random_pose(wayfare::Rng& rng) const {
    return {rng.uniform(0.0, length_m), 0.0, wayfare::Angle()};
  }
};

struct Ends {
  double log_likelihood(const wayfare::SE2d& pose, const wayfare::LaserScan& scan,
                        const Corridor& corridor) const {
    const double ahead = corridor.length_m - pose.x() - static_cast<double>(scan.ranges_m[0]);
    const double behind = pose.x() - static_cast<double>(scan.ranges_m[1]);
    return -0.5 * (ahead * ahead + behind * behind) / 0.01;
  }
};

bool whole_recording() {
  using namespace wayfare;
  Recording recording;
  for (int k = 0; k < 30; ++k) {
    const LogTime time = LogTime::from_seconds(0.5 * k);
    const auto x = static_cast<float>(2.0 + 0.2 * k);
    recording.scans.push_back({time, Angle(), Angle::degrees(180), 0.05F, 20.0F, {12.0F - x, x}});
    recording.odometry.push_back(
        {time, Transform2<frame::Odom, frame::Base>(SE2d(0.2 * k, 0.0, Angle()))});
  }
  MonteCarloOptions options;
  options.min_candidates = 5000;
  BasicLocaliser localiser(std::make_shared<const Corridor>(), Ends{}, Wheels{}, options, 1);
  const auto run = run_localisation(recording, localiser);
  return run && run->outcomes.size() == 30 &&
         std::abs(run->outcomes.back().T_map_base.mean.x() - 7.8) < 0.1;
}

}  // namespace

bool own_localiser() {
  using namespace wayfare;
  if (!whole_recording()) return false;
  MonteCarloOptions options;
  options.min_candidates = 20000;
  BasicLocaliser localiser(std::make_shared<const Floor>(), Light{}, Wheels{}, options, 1);
  SE2d truth(2.0, 1.5, Angle::degrees(20));
  bool found = false;
  for (int k = 0; k < 40; ++k) {
    truth = truth * SE2d(0.12, 0.0, Angle::degrees(3));
    const auto outcome =
        localiser.add_scan(LogTime::from_seconds(0.5 * k), LightSensors{LightSensors::at(truth)},
                           Transform2<frame::Odom, frame::Base>(truth));
    if (!outcome) return false;
    found = (outcome->T_map_base.mean.translation() - truth.translation()).norm() < 0.1;
  }
  return found;
}
