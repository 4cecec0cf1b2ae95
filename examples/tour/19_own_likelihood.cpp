// Monte-Carlo localisation by ranges to radio beacons: a map, a likelihood and a model of odometry
// of one's own. The robot is found anywhere, and found again after it was carried away.
#include <cmath>
#include <cstdio>

#include <wayfare/slam/basic_localiser.hpp>

using namespace wayfare;
struct Beacons {
  std::vector<Eigen::Vector2d> places_m;
  SE2d random_pose(Rng& rng) const {
    const Angle heading = Angle::degrees(rng.uniform(-180.0, 180.0));
    return {rng.uniform(0.0, 30.0), rng.uniform(0.0, 20.0), heading};
  }
};
using Ranges = std::vector<double>;  // m, to each beacon
struct RangeLikelihood {             // Cauchy: reflections make some ranges too long
  double log_likelihood(const SE2d& pose, const Ranges& ranges, const Beacons& map) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < ranges.size(); ++i) {
      const double d = (map.places_m[i] - pose.translation()).norm() - ranges[i];
      sum -= std::log1p(d * d / (0.2 * 0.2));
    }
    return sum;
  }
};

struct SlippingWheels {  // the robot moves at most as far as its wheels say
  auto motion(const SE2d& increment) const {
    return [increment](const SE2d& pose, Rng& rng) {
      const Angle turn = increment.heading() + Angle::degrees(rng.normal());
      return pose * SE2d(increment.x() * rng.uniform(0.8, 1.0), increment.y(), turn);
    };
  }
};

int main() {
  const Beacons beacons{{{0.0, 0.0}, {28.0, 2.0}, {5.0, 19.0}, {30.0, 17.0}, {14.0, 8.0}}};
  BasicLocaliser localiser(std::make_shared<const Beacons>(beacons), RangeLikelihood{},
                           SlippingWheels{}, MonteCarloOptions{}, 1);
  SE2d truth(6.0, 6.0, Angle::degrees(0)), odometry;
  Rng rng(1);
  bool found = false, lost = false;
  for (int k = 0; k < 160; ++k) {
    if (k == 80) truth = SE2d(21.0, 11.0, Angle::degrees(120));  // carried there
    truth = truth * SE2d(0.18, 0.0, Angle::degrees(4));
    odometry = odometry * SE2d(0.2, 0.0, Angle::degrees(4));
    Ranges ranges;
    for (const auto& place : beacons.places_m)
      ranges.push_back((place - truth.translation()).norm() + rng.normal(0.0, 0.1) +
                       (rng.uniform() < 0.1 ? 3.0 : 0.0));
    const Transform2<frame::Odom, frame::Base> measured(odometry);
    const auto outcome = localiser.add_scan(LogTime::from_seconds(k), ranges, measured);
    if (!outcome) return 1;
    const double off = (outcome->T_map_base.mean.translation() - truth.translation()).norm();
    found = found || (k < 80 && outcome->converged && off < 0.3);
    lost = lost || (k >= 80 && off > 3.0);
    if (k == 159 && found && lost) std::printf("found twice: %.2f m off\n", off);
  }
}
