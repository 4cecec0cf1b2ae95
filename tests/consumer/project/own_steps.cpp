#include "links.hpp"

#include <cmath>

#include <wayfare/pedestrian.hpp>

// A step length model and a stance statistic of one's own.
namespace {

struct ByHeight {
  double height_m = 1.75;
  double operator()(const wayfare::Step&) const { return 0.4 * height_m; }
};

struct Rate {
  double operator()(const wayfare::StanceWindow& window) const {
    double sum = 0.0;
    for (const wayfare::ImuSample& s : window) sum += s.angular_rate_radps.squaredNorm();
    return 100.0 * sum / static_cast<double>(window.size());
  }
};

}  // namespace

bool own_steps() {
  using namespace wayfare;
  BasicPedestrianParameters<ByHeight> parameters;
  parameters.length.height_m = 2.0;
  parameters.ahrs.use_magnetometer = false;
  BasicPedestrian walker(parameters);
  BasicFootTracker foot(FootParameters{}, Rate{});
  for (int i = 1; i <= 2000; ++i) {  // five seconds at rest, then two steps a second
    const double bounce = i < 500 ? 0.0 : 3.0 * std::cos(0.12566 * i);
    MargSample s;
    s.time = LogTime::from_nanoseconds(std::int64_t{10'000'000} * i);
    s.angular_rate_radps = {0.0, 0.001 * std::cos(0.1 * i), 0.0};
    s.specific_force_mps2 = {0.0, 0.0, 9.80665 + bounce};
    walker.add(s);
    if (i < 500) foot.add(ImuSample{s.time, s.angular_rate_radps, s.specific_force_mps2});
  }
  const double steps = static_cast<double>(walker.report().steps);
  return steps > 25.0 && std::abs(walker.report().distance_m - 0.8 * steps) < 1e-9 &&
         foot.report().stances > 0 && foot.pose().position_m.norm() < 0.05;
}
