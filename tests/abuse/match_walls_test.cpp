// Corridor walls, refinement, interpolation and pose proposals at the border of what they take.

#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/match/gauss_newton.hpp>
#include <wayfare/match/lines.hpp>
#include <wayfare/match/pose_proposal.hpp>

#include "abuse/abuse.hpp"
#include "abuse/map_cases.hpp"

namespace wayfare::tests {
namespace {

LaserScan corridor_scan(int k = 0) {
  Rng rng(static_cast<std::uint64_t>(k) + 5);
  return Walls::corridor(Angle()).scan(SE2d(0.0, 0.1 * k, Angle::degrees(2.0 * k)), rng, 0.003);
}

void observe(const std::optional<CorridorWalls>& walls, Observed& out) {
  out.push_back(walls ? 1 : 0);
  if (!walls) return;
  out.insert(out.end(), {walls->direction.radians(), walls->correlation, walls->width_m()});
  out.insert(out.end(), walls->covariance.data(), walls->covariance.data() + 9);
  for (const auto* wall : {&walls->left, &walls->right})
    if (*wall) out.insert(out.end(), {(*wall)->offset_m, (*wall)->begin_m, (*wall)->end_m});
  if (walls->end) out.insert(out.end(), {walls->end->rho_m, walls->end->alpha.radians()});
}

/// Whatever is found is made of numbers.
void expect_numbers(const std::optional<CorridorWalls>& walls) {
  Observed numbers;
  observe(walls, numbers);
  for (const double n : numbers) EXPECT_TRUE(std::isfinite(n));
}

CorridorWalls both_walls(double direction = 0.0) {
  CorridorWalls walls;
  walls.direction = Angle::radians(direction);
  walls.left = Wall{1.2, 50, -5, 5};
  walls.right = Wall{-1.2, 50, -5, 5};
  return walls;
}

TEST(MatchWalls, ScansWithoutWalls) {
  WallDetector detector;
  std::vector<LaserScan> scans(1);
  for (const float range : {0.0F, -1.0F, kNanF, kInfF, 3e38F, 1e-30F, 1.0F}) {
    for (const std::size_t n : {1U, 2U, 5U, 360U}) {
      LaserScan scan = corridor_scan();
      scan.max_range_m = kInfF;
      scan.ranges_m.assign(n, range);
      scans.push_back(scan);
      scan.bearing_step = Angle();  // all beams equal
      scans.push_back(scan);
    }
  }
  for (const double bad : {kNan, kInf, -kInf, kHuge, 1e308}) {
    scans.push_back(corridor_scan());
    scans.back().bearing_step = Angle::radians(bad);
    scans.push_back(corridor_scan());
    scans.back().first_bearing = Angle::radians(bad);
  }
  for (const LaserScan& scan : scans) {
    expect_numbers(detector.acquire(scan));
    expect_numbers(detector.search(scan));
    expect_numbers(detector.track(scan, both_walls()));
  }
  EXPECT_FALSE(detector.acquire(scans[0]));
  EXPECT_FALSE(detector.search(scans[0]));
  EXPECT_FALSE(detector.track(scans[0], both_walls()));
  // And the detector is as before.
  const auto walls = detector.acquire(corridor_scan());
  ASSERT_TRUE(walls && walls->left && walls->right);
  EXPECT_NEAR(walls->width_m(), 2.4, 0.01);
}

TEST(MatchWalls, OptionsWithoutMeaning) {
  const LaserScan scan = corridor_scan();
  const CorridorWalls predicted = both_walls();
  const auto try_all = [&](const WallOptions& options) {
    WallDetector detector(options);
    expect_numbers(detector.acquire(scan));
    expect_numbers(detector.search(scan));
    expect_numbers(detector.track(scan, predicted));
  };
  double WallOptions::*const reals[] = {
      &WallOptions::max_range_m,     &WallOptions::split_m,          &WallOptions::break_m,
      &WallOptions::min_segment_m,   &WallOptions::min_support_m,    &WallOptions::min_width_m,
      &WallOptions::max_width_m,     &WallOptions::capture_m,        &WallOptions::tracking_m,
      &WallOptions::min_correlation, &WallOptions::min_beam_fraction};
  for (const auto real : reals)
    for (const double value : {kNan, kInf, -kInf, 0.0, -1.0, 1e9, kHuge, kTiny}) {
      WallOptions options;
      options.*real = value;
      try_all(options);
    }
  for (const int count : {0, -1, 1000000000, std::numeric_limits<int>::min()}) {
    try_all({.min_segment_points = count});
    try_all({.min_beams = std::max(count, 1)});
  }
  // Everything is a wall, however wide: the histogram ends where the ranges end.
  WallOptions wide;
  wide.max_width_m = kHuge;
  wide.max_range_m = kHuge;
  WallDetector detector(wide);
  LaserScan far = scan;
  far.max_range_m = kInfF;
  for (std::size_t i = 0; i < far.ranges_m.size(); i += 3) far.ranges_m[i] = 3e38F;
  expect_numbers(detector.search(far));
}

TEST(MatchWalls, PredictionsThatAreNone) {
  WallDetector detector;
  const LaserScan scan = corridor_scan();
  EXPECT_FALSE(detector.track(scan, CorridorWalls()));
  ASSERT_TRUE(detector.track(scan, both_walls()));
  for (const double bad : {kNan, kInf, -kInf, 1e9, kHuge}) {
    SCOPED_TRACE(bad);
    EXPECT_FALSE(detector.track(scan, both_walls(bad == 1e9 || bad == kHuge ? kNan : bad)));
    CorridorWalls walls = both_walls();
    walls.left->offset_m = walls.right->offset_m = bad;
    EXPECT_FALSE(detector.track(scan, walls));
    walls = both_walls();
    walls.covariance.setConstant(bad);
    expect_numbers(detector.track(scan, walls));
    walls = both_walls();
    walls.end = NormalPoint{bad, Angle::radians(bad)};
    expect_numbers(detector.track(scan, walls));
    for (const std::optional<Angle> near : {std::optional(Angle::radians(bad))}) {
      expect_numbers(detector.acquire(scan, near));
      expect_numbers(detector.search(scan, near));
    }
  }
  // A beam exactly along the direction, without return, and the right wall nearly at the laser.
  CorridorWalls walls = both_walls();
  walls.left.reset();
  walls.right->offset_m = -0.3;
  LaserScan none;
  none.bearing_step = Angle::degrees(1);
  none.max_range_m = 12.0F;
  none.ranges_m.assign(90, 0.0F);
  EXPECT_FALSE(detector.track(none, walls));
}

TEST(MatchWalls, MovesAndReversals) {
  EXPECT_FALSE(moved(CorridorWalls(), SE2d(kNan, 1e9, Angle())).left);
  EXPECT_EQ(reversed(CorridorWalls()).width_m(), 0.0);
  CorridorWalls walls = both_walls(0.3);
  walls.covariance = Eigen::Vector3d(1e-4, 1e-3, 2e-3).asDiagonal();
  const CorridorWalls twice = reversed(reversed(walls));
  EXPECT_NEAR(twice.direction.radians(), 0.3, 1e-15);
  EXPECT_EQ(twice.left->offset_m, walls.left->offset_m);
  EXPECT_EQ(twice.covariance, walls.covariance);
  const CorridorWalls there = moved(walls, SE2d(1e9, -1e9, Angle::radians(1e9)));
  EXPECT_TRUE(std::isfinite(there.left->offset_m));
  EXPECT_NEAR(there.width_m(), walls.width_m(), 1e-6);
}

TEST(MatchWalls, DetectorsLife) {
  const auto probe = [](WallDetector& d) {
    Observed out;
    for (int k = 0; k < 3; ++k) {
      LaserScan scan = corridor_scan(k);
      if (k == 1) scan.ranges_m.resize(200);
      observe(d.acquire(scan), out);
      observe(d.search(scan), out);
      observe(d.track(scan, both_walls()), out);
    }
    return out;
  };
  WallDetector used;
  const Observed expected = probe(used);
  expect_value_semantics(used, probe);
  WallDetector taken = std::move(used);
  EXPECT_EQ(probe(used), expected);  // NOLINT(bugprone-use-after-move)
  const auto both = in_two_threads([&](int) {
    WallDetector own = taken;
    return probe(own);
  });
  EXPECT_EQ(both[0], expected);
  EXPECT_EQ(both[1], expected);
}

// --- Refinement ------------------------------------------------------------------------------

TEST(MatchWalls, InterpolationAnywhere) {
  const auto field = make<LikelihoodField>(2);
  for (const double far : {kNan, kInf, -kInf, 1e9, -kHuge})
    for (const Eigen::Vector2d& p : {Eigen::Vector2d(far, 0), Eigen::Vector2d(0, far)}) {
      const FieldSample sample = interpolate(field, p);
      EXPECT_EQ(sample.log_likelihood, field.log_floor());
      EXPECT_TRUE(sample.gradient.isZero(0));
    }
  EXPECT_EQ(interpolate(LikelihoodField(), {0, 0}).log_likelihood, 0.0);
}

TEST(MatchWalls, RefinementOfOddStarts) {
  const auto field = make<LikelihoodField>(2);
  const PointSet points = points_in_room(1);
  const SE2d at = pose_in_room(1);
  EXPECT_FALSE(refine(LikelihoodField(), points, at));
  EXPECT_FALSE(refine(field, PointSet(), at));
  EXPECT_FALSE(refine(field, points_at({{kNanF, 0}}), at));
  for (const double bad : kNotFinite) {
    EXPECT_FALSE(refine(field, points, SE2d(bad, 0, Angle())));
    EXPECT_FALSE(refine(field, points, SE2d(0, 0, Angle::radians(bad))));
  }
  const auto expect_sound = [&](const PointSet& p, const SE2d& start, const RefineOptions& o) {
    const auto found = refine(field, p, start, o);
    ASSERT_TRUE(found);
    EXPECT_TRUE(found->T_map_points.translation().allFinite());
    EXPECT_TRUE(found->information.allFinite());
    EXPECT_TRUE(found->score >= -1e-6 && found->score <= 1 + 1e-6) << found->score;
    const double shift = (found->T_map_points.translation() - start.translation()).norm();
    EXPECT_LE(shift, o.max_shift_m > 0 ? o.max_shift_m : 0.0);
  };
  for (const std::size_t n : {1U, 2U, 513U})
    expect_sound(points_at(std::vector<Eigen::Vector2f>(n, points[3])), at, {});
  for (const float far : {1e9F, 1e20F, 3e38F}) {
    PointSet some = points;
    some.push_back({far, far});
    expect_sound(some, at, {});
    expect_sound(points, SE2d(static_cast<double>(far), 0, Angle()), {});
  }
  expect_sound(points, SE2d(1e300, -1e300, Angle()), {});
  for (const double shift : {kNan, kInf, 0.0, -1.0, 1e9})
    for (const int iterations : {-1, 0, 300})
      for (const double tolerance : {kNan, 0.0, kInf})
        expect_sound(points, at, {iterations, tolerance, shift});
}

// --- Pose proposals --------------------------------------------------------------------------

Gaussian<SE2d> gaussian(const SE2d& mean, const Eigen::Vector3d& sigmas) {
  return {mean, sigmas.cwiseAbs2().asDiagonal()};
}

TEST(MatchWalls, ProposalsRefuseWhatHasNoDensity) {
  const auto field = make<LikelihoodField>(2);
  const PointSet points = points_in_room(1);
  const auto good = gaussian(pose_in_room(1), {0.05, 0.05, 0.02});
  PoseProposal proposal;
  Rng rng(3);
  const auto draw = [&](const Gaussian<SE2d>& q, const Gaussian<SE2d>& p,
                        const PoseProposalOptions& o = {}) {
    const auto drawn = proposal.draw(field, points, q, p, rng, o);
    if (!drawn) return false;
    EXPECT_TRUE(drawn->T_map_points.translation().allFinite());
    EXPECT_TRUE(std::isfinite(drawn->T_map_points.heading().radians()));
    EXPECT_TRUE(std::isfinite(drawn->log_evidence));
    EXPECT_TRUE(drawn->moments.covariance.allFinite());
    return true;
  };
  EXPECT_TRUE(draw(good, good));
  EXPECT_FALSE(proposal.draw(LikelihoodField(), points, good, good, rng));
  for (const PointSet& bad : {PointSet(), points_at({{kNanF, 0}}), points_at({{0, 0}, {0, kInfF}})})
    EXPECT_FALSE(proposal.draw(field, bad, good, good, rng));
  EXPECT_TRUE(proposal.draw(field, points_at({{1, 1}}), good, good, rng));
  EXPECT_TRUE(proposal.draw(field, points_at({{3e38F, -3e38F}}), good, good, rng));
  std::vector<Gaussian<SE2d>> none;
  for (const double bad : kNotFinite) {
    none.push_back(gaussian(SE2d(bad, 0, Angle()), {0.05, 0.05, 0.02}));
    none.push_back(gaussian(SE2d(0, 0, Angle::radians(bad)), {0.05, 0.05, 0.02}));
    none.push_back({SE2d(), Eigen::Matrix3d::Constant(bad)});
    none.push_back({SE2d(), Eigen::Vector3d(1, bad, 1).asDiagonal()});
  }
  none.push_back({SE2d(), Eigen::Matrix3d::Zero()});
  none.push_back({SE2d(), Eigen::Matrix3d::Ones()});
  none.push_back({SE2d(), -Eigen::Matrix3d::Identity()});
  none.push_back({SE2d(), Eigen::Vector3d(1, 1, 0).asDiagonal()});
  for (const auto& bad : none) {
    EXPECT_FALSE(draw(bad, good)) << bad.covariance;
    EXPECT_FALSE(draw(good, bad)) << bad.covariance;
  }
  // Densities too narrow, too wide or too far for numbers are an Error or numbers.
  for (const double sigma : {kTiny, 1e-154, 1e-100, 1e-12, 1e-6, 1e3, 1e9, 1e100, 1e154})
    for (const SE2d& mean :
         {pose_in_room(1), SE2d(1e9, 0, Angle()), SE2d(kHuge, -kHuge, Angle())}) {
      const auto other = gaussian(mean, Eigen::Vector3d::Constant(sigma));
      Gaussian<SE2d> tilted = other;
      tilted.covariance(0, 2) = tilted.covariance(2, 0) = 0.9 * sigma * sigma;
      for (const auto& each : {other, tilted})
        for (const bool divide : {false, true}) {
          (void)draw(each, each, {.divide_by_proposal = divide});
          (void)draw(each, good, {.divide_by_proposal = divide});
          (void)draw(good, each, {.divide_by_proposal = divide});
        }
    }
  EXPECT_TRUE(draw(gaussian(pose_in_room(1), Eigen::Vector3d::Constant(1e3)), good));
  for (const double bad : {kNan, kInf, 0.0, -1.0})
    EXPECT_FALSE(draw(good, good, {.reach_sigmas = bad}));
  for (const int bad : {0, -1, std::numeric_limits<int>::max(), std::numeric_limits<int>::min()}) {
    EXPECT_FALSE(draw(good, good, {.samples = bad}));
    EXPECT_FALSE(draw(good, good, {.headings = bad}));
  }
  EXPECT_FALSE(draw(good, good, {.independent_points = kNan}));
  for (const double n : {0.0, kTiny, 1.0, kInf})
    EXPECT_TRUE(draw(good, good, {.independent_points = n}));
  EXPECT_TRUE(draw(good, good, {.samples = 1, .headings = 1, .reach_sigmas = 1e6}));
}

TEST(MatchWalls, ProposalsLife) {
  const auto field = make<LikelihoodField>(2);
  const auto probe = [&](PoseProposal& p) {
    Rng rng(8);
    Observed out;
    for (const int k : {1, 2, 0}) {
      const auto around = gaussian(pose_in_room(k), {0.05, 0.1, 0.02 * (k + 1)});
      const auto drawn = p.draw(field, points_in_room(k), around, around, rng);
      EXPECT_TRUE(drawn);
      out.insert(out.end(), {drawn->T_map_points.x(), drawn->T_map_points.y(),
                             drawn->T_map_points.rotation().sin(), drawn->log_evidence});
    }
    return out;
  };
  PoseProposal used;
  const Observed expected = probe(used);
  expect_value_semantics(used, probe);
  PoseProposal taken = std::move(used);
  EXPECT_EQ(probe(used), expected);  // NOLINT(bugprone-use-after-move)
  const auto both = in_two_threads([&](int) {
    PoseProposal own = taken;
    return probe(own);
  });
  EXPECT_EQ(both[0], expected);
  EXPECT_EQ(both[1], expected);
}

}  // namespace
}  // namespace wayfare::tests
