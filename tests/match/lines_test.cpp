// Corridor walls in simulated scans, for any laser heading, with clutter in view.

#include <wayfare/match/lines.hpp>

#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/sim/worlds.hpp>

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
  EXPECT_NEAR(errors.normalised / errors.scans, 1.0, 0.25);
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

TEST(LinesInRooms, NoDirectionFarFromTheExpectedOrWithoutWalls) {
  WallDetector detector;
  EXPECT_FALSE(detector.square_direction(room_scan(Angle::degrees(0), false), Angle::degrees(30),
                                         Angle::degrees(15)));
  EXPECT_FALSE(detector.square_direction(LaserScan{}, {}, Angle::degrees(45)));
}

// A door of a metre in the right wall, two metres ahead; the wall behind it is farther than the
// jump.
TEST(LinesInRooms, ADoorHasAnEdgeBeforeAndAfterIt) {
  const auto plan = sim::FloorPlan::from_segments(
      {{{-10, 1}, {10, 1}}, {{-10, -1}, {2, -1}}, {{3, -1}, {10, -1}}, {{-10, -3}, {10, -3}}});
  WallDetector detector;
  Rng rng(6);
  for (const double x : {0.5, 2.2, 2.8}) {
    const SE2d pose(x, 0.2, Angle::radians(0.1));
    const LaserScan scan = sim::simulate_scan(
        *plan, [&](LogTime) { return pose; }, {}, sim::CorridorDriveParams::lms200(), rng);
    const auto walls = detector.acquire(scan);
    ASSERT_TRUE(walls && walls->right);
    const auto edges = detector.edges(scan, *walls);
    bool ends = x > 2.0, begins = x > 3.0;  // an edge behind is not in view
    for (const WallEdge& e : edges) {
      EXPECT_FALSE(e.left);
      const double at = x + e.along_m, truth = e.gap_ahead ? 2.0 : 3.0;
      EXPECT_NEAR(at, truth, 4.0 * e.sigma_m + 0.02);
      (e.gap_ahead ? ends : begins) = true;
    }
    EXPECT_TRUE(ends);
    EXPECT_TRUE(begins);
  }
  EXPECT_TRUE(detector.edges(LaserScan{}, {}).empty());
}

}  // namespace
}  // namespace wayfare
