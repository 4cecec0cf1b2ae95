// A unit on a foot, tracked with a stance statistic of one's own: MAG, the magnitude of the
// specific force alone (Skog et al. 2010), and the larger of it and the library's.
#include <algorithm>
#include <cstdio>

#include <wayfare/pedestrian/foot_tracker.hpp>
#include <wayfare/sim/walks.hpp>

using namespace wayfare;

struct Magnitude {
  double gravity_mps2 = 9.80665, sigma_mps2 = 0.2;
  double operator()(const StanceWindow& window) const {
    double sum = 0.0;
    for (const ImuSample& s : window) {
      const double off = (s.specific_force_mps2.norm() - gravity_mps2) / sigma_mps2;
      sum += off * off;
    }
    return sum / static_cast<double>(window.size());
  }
};

struct Both {
  Magnitude magnitude;
  ShoeOrAred shoe;
  double operator()(const StanceWindow& window) const {
    return std::max(magnitude(window), shoe(window));
  }
};

template <class Tracker>
void report(const char* name, Tracker tracker, const sim::FootTruth& foot) {
  for (const ImuSample& s : foot.samples) tracker.add(s);
  tracker.finish([](const FootPose&) {});
  std::printf("%s: %d stances, %.2f m off; ", name, int(tracker.report().stances),
              (tracker.pose().position_m - foot.position.back()).norm());
}

int main() {
  const ImuNoise noise;
  const sim::FeetTruth feet = sim::simulate_feet({}, noise, Rng(1));
  std::printf("%.0f m: ", feet.length_m);
  report("SHOE", FootTracker(), feet.left);
  report("MAG", BasicFootTracker(FootParameters{}, Magnitude{}), feet.left);
  report("both", BasicFootTracker(FootParameters{}, Both{}), feet.left);
  std::printf("\n");
}
