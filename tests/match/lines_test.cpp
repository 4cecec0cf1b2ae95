// Corridor walls in simulated scans, for any laser heading, with clutter in view.

#include <wayfare/match/lines.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/LU>

#include <wayfare/sim/worlds.hpp>

#include "walls.hpp"

namespace wayfare {
namespace {

constexpr double kPi = std::numbers::pi;

struct Scene {
  LaserScan scan;
  Angle direction;  ///< of the corridor, in the laser's axes
  double left_m, right_m;
};

/// A furnished corridor of 30 m along x, at a random heading of the laser.
Scene random_scene(std::size_t beams, const sim::CorridorFurniture& furniture, Rng& rng,
                   double heading) {
  const double half = rng.uniform(0.75, 1.6);
  std::vector<sim::Segment> walls;
  sim::append_furnished_wall({-15, -half}, {15, -half}, half - 0.6, furniture, rng, walls);
  sim::append_furnished_wall({15, half}, {-15, half}, half - 0.6, furniture, rng, walls);
  const auto plan = sim::FloorPlan::from_segments(walls);
  const double y = rng.uniform(-0.3, 0.3);
  const SE2d pose(rng.uniform(-5.0, 5.0), y, Angle::radians(heading));
  sim::Lidar2dParams lidar = sim::CorridorDriveParams::lms200();
  lidar.beams = beams;
  const double span = beams > 400 ? 270.0 : 180.0;  // field of view of a LMS-111
  lidar.first_bearing = Angle::degrees(-0.5 * span);
  lidar.bearing_step = Angle::degrees(span / static_cast<double>(beams - 1));
  return {sim::simulate_scan(
              *plan, [&](LogTime) { return pose; }, {}, lidar, rng),
          Angle::radians(-heading), half - y, -half - y};
}

const sim::CorridorFurniture kDoorsAndClutter{.door_spacing_m = 3.0,
                                              .open_share = 0.4,
                                              .recess_m = 0.06,
                                              .boxes_per_m = 0.1,
                                              .people_per_m = 0.05};

struct Errors {
  double angle2 = 0, offset2 = 0, normalised = 0;
  int scans = 0, walls = 0, failures = 0;

  void add(const Scene& s, const std::optional<CorridorWalls>& found) {
    ++scans;
    if (!found) {
      ++failures;
      return;
    }
    const double error = std::remainder((found->direction - s.direction).radians(), kPi);
    const bool same_way =
        std::abs(wrap_to_pi((found->direction - s.direction).radians())) < 0.5 * kPi;
    const CorridorWalls w = same_way ? *found : reversed(*found);
    angle2 += error * error;
    normalised += error * error / w.covariance(0, 0);
    bool good = std::abs(error) < 0.02;
    for (const auto& [wall, truth] : {std::pair{w.left, s.left_m}, std::pair{w.right, s.right_m}}) {
      if (!wall) continue;
      offset2 += (wall->offset_m - truth) * (wall->offset_m - truth);
      good = good && std::abs(wall->offset_m - truth) < 0.05;
      ++walls;
    }
    failures += good ? 0 : 1;
  }
  [[nodiscard]] double angle_rms_deg() const { return std::sqrt(angle2 / scans) * 180.0 / kPi; }
  [[nodiscard]] double offset_rms_m() const { return std::sqrt(offset2 / walls); }
};

class LinesInScans : public testing::TestWithParam<std::size_t> {};
INSTANTIATE_TEST_SUITE_P(Beams, LinesInScans, testing::Values(181, 361, 541));

TEST_P(LinesInScans, AreFoundAmongDoorsAndClutterInAThousandScans) {
  Rng rng(7);
  WallDetector detector;
  Errors acquired, searched, tracked;
  for (int i = 0; i < 1000; ++i) {
    const Scene s = random_scene(GetParam(), kDoorsAndClutter, rng, rng.uniform(-0.6, 0.6));
    acquired.add(s, detector.acquire(s.scan));
    searched.add(s, detector.search(s.scan));
    CorridorWalls predicted;
    const double turn_sigma = 0.2 * kPi / 180.0, offset_sigma = 0.01;
    predicted.direction = s.direction + Angle::radians(rng.normal(0.0, turn_sigma));
    predicted.covariance.diagonal() << turn_sigma * turn_sigma, offset_sigma * offset_sigma,
        offset_sigma * offset_sigma;
    predicted.left = Wall{s.left_m + rng.normal(0.0, offset_sigma)};
    predicted.right = Wall{s.right_m + rng.normal(0.0, offset_sigma)};
    tracked.add(s, detector.track(s.scan, predicted));
  }
  for (const Errors* e : {&acquired, &tracked}) {
    EXPECT_EQ(e->failures, 0);
    EXPECT_LE(e->angle_rms_deg(), 0.1);
    EXPECT_LE(e->offset_rms_m(), 0.01);
  }
  // The source's search over whole degrees finds the same walls more slowly.
  EXPECT_LE(searched.failures, 3);
  EXPECT_LE(searched.angle_rms_deg(), 0.1);
  EXPECT_LE(searched.offset_rms_m(), 0.01);
}

TEST(Lines, HaveNoSingularDirectionAndConsistentCovariances) {
  Rng rng(2);
  WallDetector detector({.flatness_m = 0.0003});  // simulated walls are flat, ranges in whole mm
  Errors errors;
  for (int degrees = -180; degrees < 180; ++degrees) {
    const double heading = degrees * kPi / 180.0;
    const Scene s = random_scene(361, {.door_spacing_m = 0.0}, rng, heading);
    errors.add(s, detector.acquire(s.scan));
  }
  EXPECT_EQ(errors.failures, 0);
  // 360 values of χ² with one degree of freedom: their mean lies within 1 ± 0.15 by 95 %.
  EXPECT_NEAR(errors.normalised / errors.scans, 1.0, 0.15);
}

/// A scan along a corridor of two given walls.
LaserScan scan_between(const std::vector<sim::Segment>& walls, const SE2d& pose = {}) {
  const auto plan = sim::FloorPlan::from_segments(walls);
  Rng rng(4);
  return sim::simulate_scan(
      *plan, [&](LogTime) { return pose; }, {}, sim::CorridorDriveParams::lms200(), rng);
}

TEST(Lines, GiveNormalPointsOfBothWallsAndTheWallAcross) {
  WallDetector detector;
  const LaserScan scan =
      scan_between({{{-5, 1}, {9, 1}}, {{9, -1.5}, {-5, -1.5}}, {{6, -1.5}, {6, 1}}});
  const auto walls = detector.acquire(scan);
  ASSERT_TRUE(walls && walls->left && walls->right && walls->end);
  EXPECT_NEAR(walls->left_point().rho_m, 1.0, 0.005);
  EXPECT_NEAR(walls->left_point().alpha.degrees(), 90.0, 0.1);
  EXPECT_NEAR(walls->right_point().rho_m, 1.5, 0.005);
  EXPECT_NEAR(walls->right_point().alpha.degrees(), -90.0, 0.1);
  EXPECT_NEAR(walls->width_m(), 2.5, 0.005);
  EXPECT_NEAR(walls->end->rho_m, 6.0, 0.01);
  EXPECT_NEAR(walls->end->alpha.degrees(), 0.0, 0.3);
  // (6) and (7): the walls seen after a motion are those predicted from it.
  const SE2d motion(0.4, 0.1, Angle::degrees(5));
  const auto after = detector.track(
      scan_between({{{-5, 1}, {9, 1}}, {{9, -1.5}, {-5, -1.5}}, {{6, -1.5}, {6, 1}}}, motion),
      moved(*walls, motion));
  ASSERT_TRUE(after && after->left && after->right && after->end);
  EXPECT_NEAR(after->left_point().rho_m, 0.9, 0.005);
  EXPECT_NEAR(after->right_point().alpha.degrees(), -95.0, 0.1);
  EXPECT_NEAR(after->end->rho_m, 5.6, 0.01);
}

TEST(Lines, GiveOnlyTheWallsThatArePresent) {
  WallDetector detector;
  const auto one = detector.acquire(scan_between({{{-5, 1}, {9, 1}}}));
  ASSERT_TRUE(one && one->left);
  EXPECT_FALSE(one->right);
  EXPECT_EQ(one->covariance(2, 2), 0.0);
  // A round room has no straight wall of the required length.
  std::vector<sim::Segment> round;
  for (int k = 0; k < 60; ++k) {
    const double a = k * kPi / 30, b = (k + 1) * kPi / 30;
    round.push_back({{3 * std::cos(a), 3 * std::sin(a)}, {3 * std::cos(b), 3 * std::sin(b)}});
  }
  EXPECT_FALSE(detector.acquire(scan_between(round)));
  LaserScan empty = scan_between(round);
  for (float& r : empty.ranges_m) r = std::nanf("");
  EXPECT_FALSE(detector.acquire(empty));
  EXPECT_FALSE(detector.search(empty));
  EXPECT_FALSE(detector.track(empty, *one));
  empty.ranges_m.clear();
  EXPECT_FALSE(detector.acquire(empty));
}

/// A scan of walls at y = 1 and −1.4, its points alternately `rough_m` before and behind them.
LaserScan scan_of_parts(double from, double to, double right_from, double right_to,
                        double rough_m) {
  Walls room;
  room.walls = {{{from, 1.0}, {to, 1.0}}, {{right_from, -1.4}, {right_to, -1.4}}};
  Rng rng(1);
  LaserScan scan = room.scan(SE2d(), rng, 0.0);
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    const double across = i % 2 == 0 ? rough_m : -rough_m;
    if (std::isfinite(scan.ranges_m[i]))
      scan.ranges_m[i] +=
          static_cast<float>(across / std::abs(std::sin(scan.bearing(i).radians())));
  }
  return scan;
}

// The covariance (AᵀA)⁻¹ Aᵀ V A (AᵀA)⁻¹ of unweighted least squares, with a row (t, 1, 0) or
// (t, 0, 1) for each beam on the left or right wall, t along it, and V the variances across,
// (σ sin φ)² + flatness². Where the n residuals exceed these, it is larger by the ratio of the
// variances, Σ e²/(n − 3) by Σ v/n.
TEST(Lines, CovarianceIsThatOfLeastSquares) {
  const WallOptions o;
  for (const double rough_m : {0.0, 0.01}) {
    const LaserScan scan = scan_of_parts(0.5, 4.0, -3.0, -0.3, rough_m);
    const auto walls = WallDetector().acquire(scan);
    ASSERT_TRUE(walls && walls->left && walls->right);
    Eigen::Matrix3d ata = Eigen::Matrix3d::Zero(), atva = ata;
    double squares = 0.0, variances = 0.0;
    int hits = 0, expected = 0;
    for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
      const double phi = (scan.bearing(i) - walls->direction).radians();
      const double r = static_cast<double>(scan.ranges_m[i]), across = std::sin(phi);
      const Wall& wall = across > 0.0 ? *walls->left : *walls->right;
      // Beams that would meet the line within the range.
      expected += std::abs(wall.offset_m) < o.max_range_m * std::abs(across) ? 1 : 0;
      const double t = r * std::cos(phi);
      if (!(r < o.max_range_m) || t < wall.begin_m - 1e-3 || t > wall.end_m + 1e-3) continue;
      ++hits;
      const Eigen::Vector3d a(t, across > 0.0 ? 1.0 : 0.0, across > 0.0 ? 0.0 : 1.0);
      const double v = std::pow(o.range_noise_m * across, 2) + o.flatness_m * o.flatness_m;
      ata += a * a.transpose();
      atva += v * a * a.transpose();
      squares += std::pow(r * across - wall.offset_m, 2);
      variances += v;
    }
    EXPECT_EQ(walls->left->beams + walls->right->beams, hits);
    EXPECT_NEAR(walls->correlation, static_cast<double>(hits) / expected, 1e-12);
    const double larger = std::max(1.0, squares / (hits - 3) * hits / variances);
    EXPECT_EQ(larger > 2.0, rough_m > 0.0) << larger;
    const Eigen::Matrix3d want = larger * ata.inverse() * atva * ata.inverse();
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        EXPECT_NEAR(walls->covariance(i, j), want(i, j), 1e-3 * std::sqrt(want(i, i) * want(j, j)))
            << i << j;
    // (ρ, α) is (|offset|, direction ± 90°): on the right the correlation changes its sign.
    for (const auto& [point, row, side] :
         {std::tuple{walls->left_point(), 1, 1.0}, {walls->right_point(), 2, -1.0}}) {
      EXPECT_EQ(point.covariance(0, 0), walls->covariance(row, row));
      EXPECT_EQ(point.covariance(1, 1), walls->covariance(0, 0));
      EXPECT_EQ(point.covariance(0, 1), side * walls->covariance(0, row));
      EXPECT_EQ(point.covariance(1, 0), point.covariance(0, 1));
    }
  }
}

// Not used are the last 4.3 cm at either end, twice the width of the window, 4 √(0.005² + 0.002²)
// m; the step between beams is r²/d · 1° at most: 0.1 m at 2 m, 0.13 m at 2.5 m from d = 1 m.
TEST(Lines, GiveTheVisiblePartOfEachWall) {
  const auto walls = WallDetector().acquire(scan_of_parts(-2.0, 2.5, -1.5, 2.8, 0.0));
  ASSERT_TRUE(walls && walls->left && walls->right);
  for (const auto& [seen, end] : {std::pair{-walls->left->begin_m, 2.0},
                                  {walls->left->end_m, 2.5},
                                  {-walls->right->begin_m, 1.5},
                                  {walls->right->end_m, 2.8}}) {
    EXPECT_LE(seen, end - 0.043);
    EXPECT_GE(seen, end - 0.043 - 2.0 * 0.13);
  }
}

// The laser moves 0.4 m along the corridor and 0.1 m to its left, and turns by 5°.
TEST(Lines, MoveWithTheLaserAndReverse) {
  CorridorWalls walls;
  walls.left = Wall{1.2, 50, -5.0, 4.0};
  walls.right = Wall{-1.3, 40, -3.0, 6.0};
  walls.end = NormalPoint{7.0, Angle::degrees(10), {}};
  walls.covariance << 1, 2, 3, 2, 5, 6, 3, 6, 9;
  const CorridorWalls next = moved(walls, SE2d(0.4, 0.1, Angle::degrees(5)));
  EXPECT_NEAR(next.direction.degrees(), -5.0, 1e-12);
  EXPECT_NEAR(next.left->offset_m, 1.1, 1e-12);
  EXPECT_NEAR(next.left->begin_m, -5.4, 1e-12);
  EXPECT_NEAR(next.left->end_m, 3.6, 1e-12);
  EXPECT_NEAR(next.right->offset_m, -1.4, 1e-12);
  EXPECT_NEAR(next.right->begin_m, -3.4, 1e-12);
  EXPECT_NEAR(next.right->end_m, 5.6, 1e-12);
  EXPECT_NEAR(next.end->alpha.degrees(), 5.0, 1e-12);
  const double a = Angle::degrees(10).radians();
  EXPECT_NEAR(next.end->rho_m, 7.0 - 0.4 * std::cos(a) - 0.1 * std::sin(a), 1e-12);
  EXPECT_EQ(next.covariance, walls.covariance);
  // In a corridor along y, the same motion is 0.4 m to the right and 0.1 m along it.
  CorridorWalls upward = walls;
  upward.direction = Angle::degrees(90);
  const CorridorWalls across = moved(upward, SE2d(0.4, 0.1, Angle::degrees(5)));
  EXPECT_NEAR(across.direction.degrees(), 85.0, 1e-12);
  EXPECT_NEAR(across.left->offset_m, 1.6, 1e-12);
  EXPECT_NEAR(across.right->begin_m, -3.1, 1e-12);
  const CorridorWalls back = reversed(walls);
  EXPECT_NEAR(std::abs(back.direction.degrees()), 180.0, 1e-12);
  EXPECT_EQ(back.left->offset_m, 1.3);  // what was on the right
  EXPECT_EQ(back.left->begin_m, -6.0);
  EXPECT_EQ(back.left->end_m, 3.0);
  EXPECT_EQ(back.left->beams, 40);
  EXPECT_EQ(back.right->offset_m, -1.2);
  EXPECT_EQ(back.right->begin_m, -4.0);
  EXPECT_EQ(back.right->end_m, 5.0);
  EXPECT_EQ(back.right->beams, 50);
  // Of (direction, −right, −left).
  EXPECT_EQ(back.covariance, (Eigen::Matrix3d() << 1, -3, -2, -3, 9, 6, -2, 6, 5).finished());
}

TEST(Lines, AreFoundNearAGivenDirectionOnly) {
  WallDetector detector;
  const LaserScan scan = scan_between({{{-5, 1}, {9, 1}}, {{9, -1.5}, {-5, -1.5}}});
  for (const double degrees : {-24.0, 20.0}) {
    const auto walls = detector.acquire(scan, Angle::degrees(degrees));
    ASSERT_TRUE(walls && walls->left) << degrees;
    EXPECT_NEAR(walls->left->offset_m, 1.0, 0.005);
    EXPECT_TRUE(detector.search(scan, Angle::degrees(degrees)));
  }
  for (const double degrees : {-30.0, 27.0, 40.0, 90.0})
    EXPECT_FALSE(detector.acquire(scan, Angle::degrees(degrees))) << degrees;
  // Of the whole degrees from 35 on, none has enough beams of either wall.
  EXPECT_FALSE(detector.search(scan, Angle::degrees(60.0)));
  // From the other side, left and right are exchanged.
  const auto back = detector.acquire(scan, Angle::degrees(170));
  ASSERT_TRUE(back && back->left && back->right);
  EXPECT_NEAR(back->left->offset_m, 1.5, 0.005);
  EXPECT_NEAR(std::abs(back->direction.degrees()), 180.0, 0.2);
}

// 0.7 m to 8 m between two walls; else only one of them is returned.
TEST(Lines, OfACorridorHaveAWidthWithinTheLimits) {
  for (const auto& [half, both] :
       {std::pair{0.36, true}, {0.34, false}, {3.9, true}, {4.1, false}}) {
    const auto walls =
        WallDetector().acquire(scan_between({{{-5, half}, {9, half}}, {{9, -half}, {-5, -half}}}));
    ASSERT_TRUE(walls) << half;
    EXPECT_EQ(walls->left && walls->right, both) << half;
  }
}

// Segments of 1.2 m in all; they end at beams, up to r²/d · ½° = 0.02 m inside of the wall's ends.
TEST(Lines, OfLessThanTheLeastSupportAreNone) {
  EXPECT_FALSE(WallDetector().acquire(scan_between({{{0.0, 1}, {1.15, 1}}})));
  EXPECT_TRUE(WallDetector().acquire(scan_between({{{0.0, 1}, {1.3, 1}}})));
}

TEST(Lines, KeepTheLongerOfTwoWallsThatAreNotParallel) {
  WallDetector detector;
  // 1.5° apart, within the tolerance of segments of one wall.
  const auto walls = detector.acquire(scan_between({{{-1, 1}, {9, 1}}, {{5, -1.35}, {-1, -1.51}}}));
  ASSERT_TRUE(walls && walls->left);
  EXPECT_FALSE(walls->parallel);
  EXPECT_FALSE(walls->right);
  EXPECT_NEAR(walls->direction.degrees(), 0.0, 0.1);
  // Of a more oblique wall, too little is parallel to the other to be accepted with it.
  const auto leaning =
      detector.acquire(scan_between({{{-1, 1}, {9, 1}}, {{5, -1.2}, {-1, -1.51}}}));
  ASSERT_TRUE(leaning && leaning->left);
  EXPECT_FALSE(leaning->right);
  EXPECT_NEAR(leaning->direction.degrees(), 0.0, 0.1);
}

TEST(Lines, StopTrackingIfPredictionAndScanDisagree) {
  WallDetector detector;
  const LaserScan scan = scan_between({{{-5, 1}, {9, 1}}, {{9, -1.5}, {-5, -1.5}}});
  auto predicted = *detector.acquire(scan);
  predicted.direction += Angle::degrees(20);
  EXPECT_FALSE(detector.track(scan, predicted));
}

TEST_P(LinesInScans, CurveFittingInWindowsFindsTheDirectionToo) {
  Rng rng(21);
  WallDetector detector;
  Errors windows, segments;
  for (int i = 0; i < 200; ++i) {
    const Scene s = random_scene(GetParam(), {}, rng, rng.uniform(-0.5, 0.5));
    windows.add(s, detector.fit_windows(s.scan));
    segments.add(s, detector.acquire(s.scan));
  }
  // Means over windows of 25 points do not reach a fit to whole walls.
  EXPECT_LT(windows.angle_rms_deg(), 0.5);
  EXPECT_LT(segments.angle_rms_deg(), windows.angle_rms_deg());
  EXPECT_LE(windows.failures, 30);  // of 200; histograms confuse a wall and a parallel one
  EXPECT_FALSE(detector.fit_windows(LaserScan{}));
}

/// A room of 8 m x 5 m whose long walls lie along `axis`, seen from its middle.
LaserScan room_scan(Angle axis, bool oblique) {
  const SO2d turn(axis);
  const auto at = [&](double x, double y) -> Eigen::Vector2d {
    return turn * Eigen::Vector2d(x, y);
  };
  std::vector<sim::Segment> walls = {{at(-4, -2.5), at(4, -2.5)},
                                     {at(4, -2.5), at(4, 2.5)},
                                     {at(4, 2.5), at(-4, 2.5)},
                                     {at(-4, 2.5), at(-4, -2.5)}};
  if (oblique) walls.push_back({at(1, 1), at(2.5, 2)});
  Rng rng(4);
  return sim::simulate_scan(
      *sim::FloorPlan::from_segments(walls), [](LogTime) { return SE2d{}; }, {},
      sim::CorridorDriveParams::lms200(), rng);
}

TEST(LinesInRooms, WallsAtRightAnglesGiveADirection) {
  WallDetector detector;
  for (const double degrees : {-30.0, 3.0, 70.0}) {
    for (const bool oblique : {false, true}) {
      const auto found =
          detector.square_direction(room_scan(Angle::degrees(degrees), oblique),
                                    Angle::degrees(degrees + 10.0 + 90.0), Angle::degrees(15));
      ASSERT_TRUE(found);
      const double off = std::remainder(found->direction.degrees() - degrees, 90.0);
      EXPECT_NEAR(off, 0.0, 0.2);
      EXPECT_GT(found->length_m, 4.0);
      EXPECT_GE(found->total_m, found->length_m);
    }
  }
}

// Walls at ±0.5° to the axis, of equal length: their mean is the axis, the spread 0.5°. The third,
// across them within the peak's ±2.5° of a right angle, would move the mean by more than its tenth.
TEST(LinesInRooms, TheSpreadOfDirectionsIsGiven) {
  const double rise = 4.0 * std::tan(Angle::degrees(0.5).radians());
  const auto found = WallDetector().square_direction(
      scan_between(
          {{{0.2, 1.5}, {4.2, 1.5 + rise}}, {{4.2, -1.5 - rise}, {0.2, -1.5}}, {{5, -1}, {6, 0}}}),
      Angle(), Angle::degrees(15));
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->direction.degrees(), 0.0, 0.1);
  EXPECT_NEAR(found->sigma_rad, Angle::degrees(0.5).radians(), 0.1 * found->sigma_rad);
  EXPECT_NEAR(found->length_m, 8.0, 0.4);
  EXPECT_NEAR(found->total_m, found->length_m + std::sqrt(2.0), 0.2);
}

TEST(LinesInRooms, NoDirectionFarFromTheExpectedOrWithoutWalls) {
  WallDetector detector;
  EXPECT_FALSE(detector.square_direction(room_scan(Angle::degrees(0), false), Angle::degrees(30),
                                         Angle::degrees(15)));
  EXPECT_FALSE(detector.square_direction(LaserScan{}, {}, Angle::degrees(45)));
}

/// The same beams, numbered from the other end.
LaserScan in_opposite_order(LaserScan scan) {
  scan.first_bearing = scan.bearing(scan.ranges_m.size() - 1);
  scan.bearing_step = Angle::radians(-scan.bearing_step.radians());
  std::ranges::reverse(scan.ranges_m);
  return scan;
}

// A door of a metre in the right or the left wall, two metres ahead; the wall behind it is farther
// than the jump.
TEST(LinesInRooms, ADoorHasAnEdgeBeforeAndAfterIt) {
  WallDetector detector;
  Rng rng(6);
  for (const double right : {1.0, -1.0}) {  // −1: in the left wall
    const auto plan = sim::FloorPlan::from_segments({{{-10, right}, {10, right}},
                                                     {{-10, -right}, {2, -right}},
                                                     {{3, -right}, {10, -right}},
                                                     {{-10, -3 * right}, {10, -3 * right}}});
    for (const double x : {0.5, 2.2, 2.8}) {
      SCOPED_TRACE(right * x);
      const SE2d pose(x, 0.2 * right, Angle::radians(0.1 * right));
      const LaserScan scan = sim::simulate_scan(
          *plan, [&](LogTime) { return pose; }, {}, sim::CorridorDriveParams::lms200(), rng);
      const auto walls = detector.acquire(scan);
      ASSERT_TRUE(walls && (right > 0.0 ? walls->right : walls->left));
      const auto edges = detector.edges(scan, *walls);
      bool ends = x > 2.0, begins = x > 3.0;  // an edge behind is not in view
      for (const WallEdge& e : edges) {
        EXPECT_EQ(e.left, right < 0.0);
        const double at = x + e.along_m, truth = e.gap_ahead ? 2.0 : 3.0;
        EXPECT_NEAR(at, truth, 4.0 * e.sigma_m + 0.02);
        // Beams r from the laser meet the wall at 1.2 m with a spacing of r²/1.2 m · ½°; the edge
        // is anywhere between two. The range's own σ is 5 mm.
        const double spacing =
            (1.2 * 1.2 + std::pow(truth - x, 2)) / 1.2 * Angle::degrees(0.5).radians();
        EXPECT_NEAR(e.sigma_m, std::hypot(spacing / std::sqrt(12.0), 0.005), 0.1 * e.sigma_m);
        (e.gap_ahead ? ends : begins) = true;
      }
      EXPECT_TRUE(ends);
      EXPECT_TRUE(begins);
      auto reversed_edges = detector.edges(in_opposite_order(scan), *walls);
      std::ranges::reverse(reversed_edges);
      ASSERT_EQ(reversed_edges.size(), edges.size());
      for (std::size_t k = 0; k < edges.size(); ++k) {
        EXPECT_NEAR(reversed_edges[k].along_m, edges[k].along_m, 1e-9);
        EXPECT_NEAR(reversed_edges[k].sigma_m, edges[k].sigma_m, 1e-9);
        EXPECT_EQ(reversed_edges[k].left, edges[k].left);
        EXPECT_EQ(reversed_edges[k].gap_ahead, edges[k].gap_ahead);
      }
    }
  }
  EXPECT_TRUE(detector.edges(LaserScan{}, {}).empty());
}

}  // namespace
}  // namespace wayfare
