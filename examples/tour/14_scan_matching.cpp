// Where was a scan taken? Correlative matching against a map made of an earlier scan, and the
// covariance of the match: in a room all is known, in a corridor the position along it is not.
#include <cmath>
#include <cstdio>

#include <wayfare/match/correlative.hpp>
#include <wayfare/sim/floor_plan.hpp>

using namespace wayfare;

PointSet scan_at(const SE2d& pose, const sim::FloorPlan& plan, std::size_t beams, double range_m,
                 Rng& rng) {
  sim::Lidar2dParams lidar = sim::full_circle(beams);
  lidar.max_range_m = range_m;
  return end_points(sim::simulate_scan(
      plan, [&](LogTime) { return pose; }, LogTime(), lidar, rng));
}

void match_in(const char* name, std::vector<sim::Segment> walls) {
  const auto plan = sim::FloorPlan::from_segments(std::move(walls)).value();
  const SE2d first(2.0, 1.0, 0_deg), second(2.2, 1.1, 5_deg), guess(2.1, 1.0, 0_deg);
  Rng rng(1);
  const PointSet before = scan_at(first, plan, 3600, 12.0, rng);
  const PointSet now = scan_at(second, plan, 360, 4.0, rng);

  const PlacedPoints placed{&before, first};
  const auto map = likelihood_field({&placed, 1}, {.resolution_m = 0.02, .sigma_m = 0.03});
  if (!map) return void(std::puts(map.error().message.c_str()));
  CorrelativeMatcher matcher;
  const auto match = matcher.match(*map, now, guess, SearchWindow{},  // 0.3 m, 20 degrees
                                   {.independent_points = 60, .covariance = true});
  if (!match) return void(std::puts(match.error().message.c_str()));
  if (!*match) return void(std::puts("no match"));

  const MatchResult& found = **match;
  const Eigen::Vector3d off = found.T_map_points.minus(second);
  const Eigen::Vector3d sigma = found.covariance->diagonal().cwiseSqrt();
  std::printf("%s: %.3f m off, sigma ahead %.3f m, aside %.3f m: %s\n", name, off.head<2>().norm(),
              sigma.x(), sigma.y(), found.constraint->complete() ? "known" : "not known ahead");
}

int main() {
  match_in("room", {{{0, 0}, {5, 0}}, {{5, 0}, {5, 4}}, {{5, 4}, {0, 4}}, {{0, 4}, {0, 0}}});
  match_in("corridor", {{{-50, 0}, {50, 0}}, {{-50, 2}, {50, 2}}});
}
