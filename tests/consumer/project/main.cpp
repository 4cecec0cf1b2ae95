#include <cmath>
#include <iostream>

#include "everything.hpp"
#include "links.hpp"
#include "other.hpp"

using namespace wayfare::literals;

int main() {
  // The compiled parts are linked, not only their headers.
#ifdef STRANGER_LINKS_IO
  if (!reads_graphs()) return 1;
#endif
#ifdef STRANGER_LINKS_DECODE
  if (!reads_chirps() || !own_framing()) return 1;
#endif
#ifdef STRANGER_LINKS_FILTER
  if (!filters() || !own_states() || !own_gates() || !own_particles()) return 1;
#endif
#ifdef STRANGER_LINKS_INERTIAL
  if (!predicts_motion()) return 1;
#endif
#ifdef STRANGER_LINKS_PEDESTRIAN
  if (!own_steps()) return 1;
#endif
#ifdef STRANGER_LINKS_SLAM
  if (!matches_scans() || !own_edges()) return 1;
#endif
#ifdef STRANGER_OWN_SYSTEMS
  if (!own_matcher() || !own_localiser() || !own_solver()) return 1;
#endif
  const wayfare::SE2d pose = turned(wayfare::SE2d(1.0, 2.0, 0.5_rad), -0.5_rad);
  std::cout << pose.log().transpose() << '\n';
  return std::abs(pose.heading().radians()) < 1e-12 ? 0 : 1;
}
