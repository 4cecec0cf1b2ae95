// A radar's frames compared with the theory of its signal processing for known reflectors.

#include <wayfare/sensors/scans.hpp>
#include <wayfare/sim/radar.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/sync/augmented_scans.hpp>

namespace wayfare::sim {
namespace {

using Eigen::Vector2d;

FloorPlan far_box() {
  return std::move(FloorPlan::from_segments({{{-50.0, -50.0}, {50.0, -50.0}},
                                             {{50.0, -50.0}, {50.0, 50.0}},
                                             {{50.0, 50.0}, {-50.0, 50.0}},
                                             {{-50.0, 50.0}, {-50.0, -50.0}}}))
      .value();
}

Reflector reflector(double x, double y, double strength_db) { return {{x, y}, strength_db}; }

RadarScan frame(const FloorPlan& plan, const std::vector<Reflector>& reflectors,
                const Vector2d& velocity = Vector2d::Zero(), std::uint64_t seed = 1,
                const RadarParams& params = {}, const SE2d& pose = {}) {
  Rng rng(seed);
  return simulate_radar(plan, reflectors, pose, velocity, LogTime{}, params, rng);
}

TEST(Radar, PointsLieOnTheProcessingGrid) {
  const std::vector<Reflector> many = {reflector(2.0, 0.5, 60.0), reflector(3.1, -1.2, 62.0),
                                       reflector(1.0, 0.1, 50.0), reflector(4.4, 2.0, 66.0)};
  const RadarScan scan = frame(far_box(), many, {0.3, 0.0});
  ASSERT_FALSE(scan.points.empty());
  for (const RadarPoint& p : scan.points) {
    const double range = std::hypot(p.x_m, p.y_m), bin = range / 0.0436;
    EXPECT_NEAR(bin, std::round(bin), 1e-4);
    const double sine = 32.0 * static_cast<double>(p.y_m) / range;
    EXPECT_NEAR(sine, std::round(sine), 1e-4);
    const double doppler = static_cast<double>(p.doppler_m_s) / 0.1217;
    EXPECT_NEAR(doppler, std::round(doppler), 1e-4);
    EXPECT_GT(p.snr_db, 9.0F);
    EXPECT_GE(p.x_m, 0.0F);
  }
}

// The strongest point is within half a bin of the truth in each coordinate; noise at -40 dB moves
// no peak by another bin.
TEST(Radar, AReflectorIsFoundAtItsPosition) {
  Rng rng(7);
  for (int i = 0; i < 50; ++i) {
    const double range = rng.uniform(0.8, 5.5), sine = rng.uniform(-0.7, 0.7);
    const Vector2d at(range * std::sqrt(1.0 - sine * sine), range * sine);
    const double strength = 45.0 + 40.0 * std::log10(range) - 60.0 * std::log10(at.x() / range);
    const Vector2d velocity(rng.uniform(-0.7, 0.7), 0.0);
    const SE2d pose(3.0, -2.0, Angle::degrees(rng.uniform(-180.0, 180.0)));
    const Vector2d in_plan = pose * at;
    const RadarScan scan =
        frame(far_box(), {reflector(in_plan.x(), in_plan.y(), strength)}, velocity, 1, {}, pose);
    ASSERT_FALSE(scan.points.empty());
    const RadarPoint& best = *std::max_element(
        scan.points.begin(), scan.points.end(),
        [](const RadarPoint& a, const RadarPoint& b) { return a.snr_db < b.snr_db; });
    const double found = std::hypot(best.x_m, best.y_m);
    EXPECT_NEAR(found, range, 0.5 * 0.0436 + 0.001);
    EXPECT_NEAR(best.y_m / found, sine, 0.75 / 32.0);
    EXPECT_NEAR(best.doppler_m_s, -velocity.x() * at.x() / range, 0.75 * 0.1217);
  }
}

// The mean of the logarithms of eight exponential powers has a standard deviation of 4.34 * 1.64 /
// sqrt(8) = 2.0 dB and lighter tails than a normal one above its mean: 9 dB is beyond 4.5 sigma,
// 4e-6 per cell. Two hundred frames have 4e5 cells, so that a handful of points may occur. The
// transmitters alternate, so that motion shifts bearings by the difference between the true speed
// and the Doppler bin's. Means over many reflectors average out the bearing bins.
TEST(Radar, MotionShiftsBearingsByTheDopplerResidualAndCanBeCorrected) {
  const RadarArray array{.max_speed_m_s = 8 * 0.1217};
  for (const double bins_off : {-0.4, 0.4}) {
    Rng rng(17);
    double raw = 0.0, right = 0.0;
    constexpr int kReflectors = 400;
    for (int i = 0; i < kReflectors; ++i) {
      const double range = rng.uniform(0.8, 3.0), sine = rng.uniform(-0.5, 0.5);
      const Vector2d at(range * std::sqrt(1.0 - sine * sine), range * sine);
      // Straight towards the reflector: two bins and a bit.
      const Vector2d velocity = (2.0 - bins_off) * 0.1217 * at / range;
      const RadarScan scan = frame(far_box(), {reflector(at.x(), at.y(), 70.0)}, velocity,
                                   static_cast<std::uint64_t>(i) + 1);
      // Its own Doppler bin; the window spreads it over the neighbours, too.
      const auto own = std::find_if(
          scan.points.begin(), scan.points.end(),
          [](const RadarPoint& p) { return std::abs(p.doppler_m_s + 2.0F * 0.1217F) < 1e-4F; });
      ASSERT_NE(own, scan.points.end());
      const auto sine_of = [](const RadarPoint& p) { return p.y_m / std::hypot(p.x_m, p.y_m); };
      raw += (static_cast<double>(sine_of(*own)) - sine) / kReflectors;
      right += (static_cast<double>(sine_of(compensate_bearing(*own, velocity, array))) - sine) /
               kReflectors;
    }
    // 4/21 of the stair of π · bins_off / 16, over π. One bin of bearing is 1/32, its mean over 400
    // uniform deviates known to 1/32/√12/20 = 4.5e-4.
    EXPECT_NEAR(raw, 4.0 / 21.0 * bins_off / 16.0, 1.5e-3);
    EXPECT_NEAR(right, 0.0, 1.5e-3);
  }
}

TEST(Radar, MovingObjectsKeepTheirBearing) {
  const RadarArray array{.max_speed_m_s = 0.97};
  const RadarPoint walker{2.0F, 1.0F, 0.0F, 0.6F, 20.0F};
  EXPECT_EQ(compensate_bearing(walker, {0.2, 0.0}, array), walker);
  // Without a known array, or with one transmitter alone: nothing to correct.
  const RadarPoint wall{2.0F, 1.0F, 0.0F, -0.1F, 20.0F};
  EXPECT_FALSE(compensate_bearing(wall, {0.2, 0.0}, array) == wall);
  EXPECT_EQ(compensate_bearing(wall, {0.2, 0.0}, {}), wall);
  EXPECT_EQ(compensate_bearing(wall, {0.2, 0.0}, {.max_speed_m_s = 0.97, .transmitters = 1}), wall);
}

TEST(Radar, NoiseAloneRarelyMakesPoints) {
  std::size_t points = 0;
  for (std::uint64_t seed = 0; seed < 200; ++seed)
    points += frame(far_box(), {}, Vector2d::Zero(), seed).points.size();
  EXPECT_LE(points, 10U);
}

TEST(Radar, PowerFallsWithTheFourthPowerOfTheDistance) {
  const auto strongest = [](double range) {
    double best = 0.0;
    const RadarScan scan = frame(far_box(), {reflector(range, 0.0, 60.0)});
    for (const RadarPoint& p : scan.points) best = std::max(best, static_cast<double>(p.snr_db));
    return best;
  };
  // Whole bins, so that no tone is between two: 40 log10(2) = 12.04 dB, the noise of the mean of 8
  // neighbours is below 1 dB.
  EXPECT_NEAR(strongest(46 * 0.0436) - strongest(92 * 0.0436), 12.04, 1.5);
}

TEST(Radar, DetectsNothingBehindItOrBeyondItsRange) {
  const std::vector<Reflector> out = {reflector(-1.0, 0.0, 70.0), reflector(6.3, 0.0, 80.0),
                                      reflector(0.3, 0.0, 40.0)};
  for (const RadarPoint& p : frame(far_box(), out).points)
    EXPECT_LE(std::hypot(p.x_m, p.y_m), 6.0F);
  for (const Reflector& r : {out[0], out[2]}) EXPECT_TRUE(frame(far_box(), {r}).points.empty());
}

FloorPlan wall_ahead() {
  return std::move(FloorPlan::from_segments({{{3.0, -4.0}, {3.0, 4.0}}})).value();
}

TEST(Radar, DetectsThroughOneWallWithLoss) {
  RadarParams params;
  const Reflector behind = reflector(4.0, 0.2, 56.0);
  EXPECT_FALSE(frame(wall_ahead(), {behind}, Vector2d::Zero(), 1, params).points.empty());
  params.walls_seen_through = 0;
  EXPECT_TRUE(frame(wall_ahead(), {behind}, Vector2d::Zero(), 1, params).points.empty());
  params.walls_seen_through = 1;
  params.wall_loss_db = 40.0;
  EXPECT_TRUE(frame(wall_ahead(), {behind}, Vector2d::Zero(), 1, params).points.empty());
}

TEST(Radar, AGhostIsVisibleThroughItsMirrorOnly) {
  const FloorPlan plan =
      std::move(FloorPlan::from_segments({{{3.0, -0.5}, {3.0, 0.5}}, {{0.0, 3.0}, {6.0, 3.0}}}))
          .value();
  Reflector ghost = reflector(4.0, 0.0, 60.0);
  ghost.mirror = 0;
  EXPECT_FALSE(frame(plan, {ghost}).points.empty());
  EXPECT_TRUE(frame(plan, {ghost}, Vector2d::Zero(), 1, {}, SE2d(0.0, 2.0, Angle{})).points.empty())
      << "the line to the image passes the mirror by";
}

TEST(Radar, AFrameHasALimitedNumberOfPoints) {
  std::vector<Reflector> many;
  for (int i = 0; i < 60; ++i) many.push_back(reflector(0.8 + 0.085 * i, 0.3 * (i % 5 - 2), 75.0));
  RadarParams params;
  params.max_points = 40;
  EXPECT_EQ(frame(far_box(), many, {0.3, 0.0}, 1, params).points.size(), 40U);
}

// A wall's panels are visible at normal incidence, its roughness at an angle as well.
TEST(Radar, SharpReflectorsVanishAtAnAngle) {
  Reflector panel = reflector(3.0, 0.0, 60.0);
  panel.normal = {1.0, 0.0};
  panel.sharpness = 40.0;
  EXPECT_FALSE(frame(far_box(), {panel}).points.empty());
  panel.normal = Vector2d(1.0, 1.0).normalized();  // cos(45 deg)^40 = -60 dB
  EXPECT_TRUE(frame(far_box(), {panel}).points.empty());
}

TEST(Reflectors, HaveTheConfiguredDensities) {
  const FloorPlan plan = far_box();  // 400 m of wall, 104 m x 104 m of ground
  FurnishParams params;
  params.ghost_from_db = 1e9;
  params.hidden_per_m2 = 0.0;
  params.diffuse_per_m2 = params.floor_per_m2 = params.floor_patches_per_m2 = 0.0;
  params.plaster.spacing_m = params.panel.spacing_m = 0.0;
  params.strut = {0.5, 48.0, 5.0, 1.0};
  params.strut_share = 0.5;
  const std::vector<Reflector> r = furnish(plan, {}, params, Rng(3));
  // 400 struts expected, Poisson: sigma 20, bound at 4 sigma; and 4 corners.
  EXPECT_NEAR(static_cast<double>(r.size()), 404.0, 80.0);
  double sum = 0.0, square = 0.0;
  std::size_t struts = 0;
  for (const Reflector& one : r) {
    if (one.sharpness == 0.0) continue;
    ++struts;
    sum += one.strength_db;
    square += (one.strength_db - 48.0) * (one.strength_db - 48.0);
  }
  const auto n = static_cast<double>(struts);
  EXPECT_NEAR(sum / n, 48.0, 4.0 * 5.0 / std::sqrt(n));
  EXPECT_NEAR(square / n, 25.0, 4.0 * 25.0 * std::sqrt(2.0 / n));
}

TEST(Reflectors, GhostsAreMirrorImages) {
  const FloorPlan plan =
      std::move(FloorPlan::from_segments({{{0.0, 0.0}, {10.0, 0.0}}, {{0.0, 2.0}, {10.0, 2.0}}}))
          .value();
  FurnishParams params;
  params.hidden_per_m2 = params.diffuse_per_m2 = params.floor_per_m2 = params.floor_patches_per_m2 =
      0.0;
  const std::vector<Reflector> r = furnish(plan, {}, params, Rng(3));
  std::size_t ghosts = 0;
  for (const Reflector& one : r) {
    if (one.mirror == Reflector::kNoMirror) continue;
    ++ghosts;
    // A reflector on one wall appears behind the other by the width of the corridor.
    EXPECT_NEAR(one.at_m.y(), one.mirror == 0 ? -2.0 : 4.0, 1e-9);
  }
  EXPECT_GT(ghosts, 0U);
}

// Bumps are uniform, and twenty times as dense in patches of 1 m; none is visible from far away.
TEST(Reflectors, FloorClutterIsUniformPlusPatches) {
  const FloorPlan plan = far_box();  // 104 m x 104 m of ground
  FurnishParams params;
  params.ghost_from_db = 1e9;
  params.hidden_per_m2 = params.diffuse_per_m2 = 0.0;
  params.plaster.spacing_m = params.panel.spacing_m = params.strut.spacing_m = 0.0;
  params.corner.strength_db = -99.0;
  const auto bumps = [&](double patches_per_m2) {
    params.floor_patches_per_m2 = patches_per_m2;
    std::size_t count = 0;
    for (const Reflector& r : furnish(plan, {}, params, Rng(3))) {
      if (!std::isfinite(r.max_range_m)) continue;
      ++count;
      EXPECT_EQ(r.max_range_m, params.floor_max_range_m);
    }
    return count;
  };
  // 0.8 · 104² uniform; 0.004 · 104² patches of 20 · 0.8 · π each.
  EXPECT_EQ(bumps(0.0), 8653U);
  EXPECT_EQ(bumps(0.004), 8653U + 43U * 50U);
}

TEST(Radar, FloorIsVisibleNearbyOnly) {
  std::vector<Reflector> bumps;
  for (double x = 0.8; x < 6.0; x += 0.4) {
    bumps.push_back(reflector(x, 0.3, 60.0));
    bumps.back().max_range_m = 2.5;
  }
  const RadarScan scan = frame(far_box(), bumps);
  EXPECT_GE(scan.points.size(), 3U);
  for (const RadarPoint& p : scan.points) EXPECT_LT(std::hypot(p.x_m, p.y_m), 2.6F);
}

TEST(Reflectors, NoHiddenObjectIsInSightOfTheRoute) {
  const FloorPlan plan = far_box();
  FurnishParams params;
  params.plaster.spacing_m = params.panel.spacing_m = params.strut.spacing_m = 0.0;
  params.diffuse_per_m2 = params.floor_per_m2 = params.floor_patches_per_m2 = 0.0;
  params.ghost_from_db = 1e9;
  for (const Reflector& one : furnish(plan, {{}, {{0.0, 0.0}}}, params, Rng(3)))
    EXPECT_GE(one.at_m.cwiseAbs().maxCoeff(), 50.0 - 1e-9);
}

}  // namespace
}  // namespace wayfare::sim
