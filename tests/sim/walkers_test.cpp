#include <wayfare/sim/walkers.hpp>

#include <algorithm>
#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include <wayfare/sim/worlds.hpp>

namespace wayfare::sim {
namespace {

using Eigen::Vector2d;

Walker ahead() { return {.from_m = {0.0, 0.0}, .to_m = {5.0, 0.0}, .speed_m_s = 1.0}; }

TEST(Walkers, WalkToAndFro) {
  const auto at = [](double s) { return walker_at(ahead(), LogTime() + from_seconds(s)).body; };
  EXPECT_NEAR(at(2.0).at_m.x(), 2.0, 1e-9);
  EXPECT_NEAR(at(7.0).at_m.x(), 3.0, 1e-9);
  EXPECT_NEAR(at(2.0).velocity_m_s.x(), 1.0, 1e-9);
  EXPECT_NEAR(at(7.0).velocity_m_s.x(), -1.0, 1e-9);
  EXPECT_NEAR(at(12.0).at_m.x(), 2.0, 1e-9);
}

TEST(Walkers, LegsHaveTheVelocityOfTheirMotionAndRestInTheirStance) {
  constexpr double kStep_s = 1e-4;
  double slowest = 1.0;
  for (double s = 0.5; s < 4.0; s += 0.01) {
    const auto before = walker_at(ahead(), LogTime() + from_seconds(s - kStep_s)),
               after = walker_at(ahead(), LogTime() + from_seconds(s + kStep_s)),
               now = walker_at(ahead(), LogTime() + from_seconds(s));
    for (const auto leg : {&WalkerParts::left, &WalkerParts::right}) {
      const Vector2d v = ((after.*leg).at_m - (before.*leg).at_m) / (2 * kStep_s);
      EXPECT_LT((v - (now.*leg).velocity_m_s).norm(), 1e-3);
      slowest = std::min(slowest, (now.*leg).velocity_m_s.norm());
    }
  }
  EXPECT_LT(slowest, 0.01);
}

TEST(Walkers, StandOnAPathWithoutLength) {
  const Walker still{.from_m = {1.0, 2.0}, .to_m = {1.0, 2.0}};
  const WalkerParts parts = walker_at(still, LogTime() + from_seconds(3.0));
  EXPECT_EQ(parts.body.at_m, Vector2d(1.0, 2.0));
  EXPECT_EQ(parts.left.velocity_m_s, Vector2d(0.0, 0.0));
}

TEST(Walkers, LegsShortenTheBeamsThatMeetThem) {
  LaserScan scan{.time = {},
                 .first_bearing = Angle::degrees(-180.0),
                 .bearing_step = Angle::degrees(1.0),
                 .min_range_m = 0.1F,
                 .max_range_m = 3.5F,
                 .ranges_m = std::vector<float>(360, 3.0F)};
  const std::array<Walker, 1> walkers{{{.from_m = {2.0, 0.0}, .to_m = {2.0, 4.0}, .start_m = 0.0}}};
  const Lidar2dParams params{.range_noise_m = 0.0};
  Rng rng(1);
  overlay_walkers(scan, walkers, SE2d(), params, rng);
  // At 18 cm from each other across the path, along x.
  EXPECT_NEAR(scan.ranges_m[180], 2.0F - 0.09F - 0.06F, 0.02F);
  EXPECT_EQ(scan.ranges_m[0], 3.0F);
  EXPECT_EQ(scan.ranges_m[200], 3.0F);
}

TEST(Walkers, TheRadarMeasuresTheirSpeed) {
  const auto plan = FloorPlan::from_segments({{{-9.0, -9.0}, {9.0, -9.0}},
                                              {{9.0, -9.0}, {9.0, 9.0}},
                                              {{9.0, 9.0}, {-9.0, 9.0}},
                                              {{-9.0, 9.0}, {-9.0, -9.0}}});
  Reflector person;
  person.at_m = {2.0, 0.0};
  person.strength_db = 60.0;
  person.velocity_m_s = {0.6, 0.0};
  const std::array<Reflector, 1> reflectors{person};
  Rng rng(3);
  const RadarParams params;
  const RadarScan scan =
      simulate_radar(*plan, reflectors, SE2d(), Vector2d(0.2, 0.0), {}, params, rng);
  ASSERT_FALSE(scan.points.empty());
  const RadarPoint& p = *std::ranges::max_element(scan.points, {}, &RadarPoint::snr_db);
  EXPECT_NEAR(p.x_m, 2.0F, 0.1F);
  EXPECT_NEAR(p.doppler_m_s, 0.4F, static_cast<float>(params.doppler_bin_m_s));
}

TEST(Walkers, WalkBesideTheLongLegsOfARoute) {
  const std::vector<Vector2d> route{{0.0, 0.0}, {2.0, 0.0}, {2.0, 20.0}};
  const auto walkers = walkers_along(route, 8, Rng(1));
  ASSERT_EQ(walkers.size(), 8U);
  for (const Walker& w : walkers) {
    EXPECT_GE(std::abs(w.from_m.x() - 2.0), 0.55);
    EXPECT_NEAR((w.to_m - w.from_m).norm(), 18.0, 1e-9);
  }
  EXPECT_TRUE(walkers_along(std::vector<Vector2d>{{0.0, 0.0}, {2.0, 0.0}}, 3, Rng(1)).empty());
}

}  // namespace
}  // namespace wayfare::sim
