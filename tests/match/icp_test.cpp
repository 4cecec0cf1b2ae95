// ICP with its kernels and tracked neighbours, compared with the same iteration written plainly in
// double precision.

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/LU>

#include <wayfare/core/statistics.hpp>
#include <wayfare/match/registration.hpp>

#include "match/local/registration.hpp"
#include "walls.hpp"

namespace wayfare {
namespace {

struct Pair {
  Eigen::Vector2d point, normal;
  double offset = 0.0, distance = 0.0;
};

std::vector<Pair> pairs_at(const SurfaceMap& map, const PointSet& points, const SE2d& pose,
                           double reach) {
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector2d p = points[i].cast<double>();
    const Eigen::Vector2f at = (pose * p).cast<float>();
    const SurfacePoint* s = map.nearest(at, static_cast<float>(reach));
    if (s == nullptr || s->normal.isZero(0)) continue;
    const Eigen::Vector2d n = s->normal.cast<double>();
    pairs.push_back(
        {p, n, n.dot(s->point.cast<double>()), static_cast<double>((s->point - at).norm())});
  }
  return pairs;
}

detail::Cost cost_of(const std::vector<Pair>& pairs, const SE2d& pose, double sigma) {
  detail::Cost cost;
  for (const Pair& pair : pairs) {
    const double r = pair.normal.dot(pose * pair.point) - pair.offset;
    const double w = 1 / (sigma * sigma + r * r);
    const Eigen::Vector2d n = pose.rotation().inverse() * pair.normal;
    const Eigen::Vector3d g(n.x(), n.y(), pair.point.x() * n.y() - pair.point.y() * n.x());
    cost.value += 0.5 * std::log1p(r * r / (sigma * sigma));
    cost.negative_gradient -= w * r * g;
    cost.hessian += w * g * g.transpose();
  }
  return cost;
}

SE2d plain_icp(const SurfaceMap& map, const PointSet& points, const SE2d& prior,
               const SearchWindow& window, const IcpOptions& o) {
  const MatchOptions none;
  const detail::Prior prior_term(prior, window, none, points);
  SE2d pose = prior;
  double reach = o.max_correspondence_m;
  for (int i = 0; i < o.max_iterations; ++i) {
    std::vector<Pair> pairs = pairs_at(map, points, pose, reach);
    const double median = upper_median_of(pairs, &Pair::distance);
    const double sigma = std::max(o.sigma_m, median);
    const SE2d before = pose;
    const auto cost_at = [&](const SE2d& at) { return cost_of(pairs, at, sigma); };
    prior_term.minimise(pose, cost_at, 3, o.tolerance);
    const double wanted = std::max(5 * o.sigma_m, 3 * median);
    const bool converged = before.minus(pose).norm() < o.tolerance && wanted >= 0.7 * reach;
    reach = std::min(reach, wanted);
    if (converged) break;
  }
  return pose;
}

// Iterations end at steps below the tolerance of 1e-4 m; from there both may be as far apart.
TEST(Icp, EqualsThePlainIterationInDoublePrecision) {
  Rng rng(41);
  const Walls room = Walls::room();
  std::vector<PointSet> views;
  std::vector<SE2d> poses;
  for (int i = 0; i < 8; ++i) {
    poses.emplace_back(rng.uniform(-2, 2), rng.uniform(-1, 1), Angle::radians(rng.uniform(-3, 3)));
    views.push_back(end_points(room.scan(poses.back(), rng)));
  }
  std::vector<PlacedPoints> placed;
  for (std::size_t i = 0; i < views.size(); ++i) placed.push_back({&views[i], poses[i]});
  const IcpOptions options;
  const IcpMatcher matcher(options);
  const auto map = matcher.make_map(placed);
  ASSERT_TRUE(map);
  const SearchWindow window{2, 2, Angle::degrees(60)};
  for (int i = 0; i < 30; ++i) {
    const SE2d truth(rng.uniform(-1.5, 1.5), rng.uniform(-1, 1),
                     Angle::radians(rng.uniform(-3, 3)));
    const PointSet seen = end_points(room.scan(truth, rng));
    const double off = rng.uniform(0.0, 0.4);  // far enough that the median sets the scale
    const SE2d start =
        truth.plus({rng.normal(0, off), rng.normal(0, off), rng.normal(0, 0.3 * off)});
    const SE2d want = plain_icp(*map, seen, start, window, options);
    const auto got = matcher.match(*map, seen, start, window);
    ASSERT_TRUE(got);
    if (!*got) continue;  // ended outside the window
    const Eigen::Vector3d apart = (*got)->T_map_points.minus(want);
    EXPECT_LT(apart.head<2>().norm(), 1e-3) << i;
    EXPECT_LT(std::abs(apart[2]), 3e-4) << i;
  }
}

// A long wall along x; on it, 1 σ and 2 σ off it, and without a pair: ln p = 0, −1/2, −2 and ln
// 0.01. The gradients are (0, 1, x). Along x only the window holds, the larger of its half extents,
// 0.5 m.
TEST(Icp, FiguresAndCovarianceOfFourPoints) {
  PointSet wall, seen;
  for (int i = -400; i <= 400; ++i) wall.push_back({0.01F * static_cast<float>(i), 1.0F});
  const PlacedPoints placed{&wall, SE2d()};
  const auto map = SurfaceMap::make({&placed, 1}, {.spacing_m = 0.01});
  ASSERT_TRUE(map);
  for (const auto& [x, y] : {std::pair{-2.0F, 1.0F}, {-1.0F, 1.03F}, {1.0F, 1.06F}, {2.0F, 2.0F}})
    seen.push_back({x, y});
  const double turn = Angle::degrees(20).radians(), floor = std::log(0.01);
  for (const SearchWindow& window :
       {SearchWindow{0.3, 0.5, Angle::degrees(20)}, SearchWindow{0.5, 0.3, Angle::degrees(20)}}) {
    const auto match =
        IcpMatcher({.max_iterations = 0, .sigma_m = 0.03})
            .match(*map, seen, SE2d(), window, {.independent_points = 2.0, .covariance = true});
    ASSERT_TRUE(match && *match && (*match)->covariance);
    const double mean = (0.0 - 0.5 - 2.0 + floor) / 4.0;
    EXPECT_NEAR((*match)->mean_log_likelihood, mean, 1e-4);
    EXPECT_NEAR((*match)->score, 1.0 - mean / floor, 1e-4);
    Eigen::Matrix3d information = Eigen::Vector3d(4.0, 4.0, 1.0 / (turn * turn)).asDiagonal();
    for (const double x : {-2.0, -1.0, 1.0}) {  // two of the four points are independent
      const Eigen::Vector3d g(0.0, 1.0, x);
      information += 0.5 / (0.03 * 0.03) * g * g.transpose();
    }
    const Eigen::Matrix3d& got = *(*match)->covariance;
    const Eigen::Matrix3d want = information.inverse();
    EXPECT_NEAR(got(0, 0), 0.25, 1e-6);
    for (int i = 1; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        EXPECT_NEAR(got(i, j), want(i, j), 1e-4 * std::sqrt(want(i, i) * want(j, j))) << i << j;
  }
}

}  // namespace
}  // namespace wayfare
