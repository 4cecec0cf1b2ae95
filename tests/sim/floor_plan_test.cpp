#include <wayfare/sim/floor_plan.hpp>

#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>
#include <Eigen/LU>

#include <wayfare/core/random.hpp>

namespace wayfare::sim {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();

Eigen::Vector2d unit(double angle) { return {std::cos(angle), std::sin(angle)}; }

std::vector<Segment> polygon(const Eigen::Vector2d& centre, double circumradius, int sides) {
  std::vector<Segment> walls;
  const auto corner = [&](int i) {
    return Eigen::Vector2d(centre + circumradius * unit(2.0 * std::numbers::pi * i / sides));
  };
  for (int i = 0; i < sides; ++i) walls.push_back({corner(i), corner(i + 1)});
  return walls;
}

FloorPlan room(double w, double h) {
  return FloorPlan::from_segments(
             {{{0, 0}, {w, 0}}, {{w, 0}, {w, h}}, {{w, h}, {0, h}}, {{0, h}, {0, 0}}})
      .value();
}

// Every wall one by one: o + t d = a + u (b - a) solved as a 2 x 2 system.
double brute_force(const std::vector<Segment>& walls, const Eigen::Vector2d& o,
                   const Eigen::Vector2d& d, double max_range) {
  double best = kInf;
  for (const Segment& s : walls) {
    Eigen::Matrix2d m;
    m << d, s.a_m - s.b_m;
    const Eigen::Vector2d tu = m.inverse() * (s.a_m - o);
    if (tu[0] >= 0 && tu[0] <= max_range && tu[1] >= 0 && tu[1] <= 1) best = std::min(best, tu[0]);
  }
  return best;
}

TEST(FloorPlan, RangesInARectangularRoomFollowFromItsWalls) {
  const FloorPlan plan = room(8.0, 5.0);
  const Eigen::Vector2d o(3.0, 2.0);
  for (int i = 0; i < 720; ++i) {
    const Eigen::Vector2d d = unit(i * std::numbers::pi / 360.0 + 1e-3);
    const double tx = ((d.x() > 0 ? 8.0 : 0.0) - o.x()) / d.x();
    const double ty = ((d.y() > 0 ? 5.0 : 0.0) - o.y()) / d.y();
    EXPECT_NEAR(plan.cast(o, d, 100.0), std::min(tx, ty), 1e-12) << i;
  }
}

TEST(FloorPlan, RangesInARegularPolygonFollowFromItsApothem) {
  // A ray at angle φ from a side's normal meets that side at apothem / cos φ.
  const int sides = 37;
  const Eigen::Vector2d centre(-4.0, 11.0);
  const FloorPlan plan = FloorPlan::from_segments(polygon(centre, 6.0, sides)).value();
  const double apothem = 6.0 * std::cos(std::numbers::pi / sides);
  const double side_angle = 2.0 * std::numbers::pi / sides;
  for (int i = 0; i < 1000; ++i) {
    const double phi = 0.00628 * i;
    const double from_normal = std::remainder(phi - side_angle / 2, side_angle);
    EXPECT_NEAR(plan.cast(centre, unit(phi), 50.0), apothem / std::cos(from_normal), 1e-12);
  }
}

TEST(FloorPlan, AgreesWithExhaustiveSearch) {
  Rng rng(11);
  for (int scene = 0; scene < 20; ++scene) {
    std::vector<Segment> walls;
    for (int i = 0; i < 60; ++i) {
      const Eigen::Vector2d a(rng.uniform(-20, 20), rng.uniform(-5, 5));
      walls.push_back({a, a + rng.uniform(0.1, 6.0) * unit(rng.uniform(0, 7))});
    }
    const FloorPlan plan = FloorPlan::from_segments(walls).value();
    for (int i = 0; i < 500; ++i) {
      const Eigen::Vector2d o(rng.uniform(-25, 25), rng.uniform(-10, 10));
      const Eigen::Vector2d d = unit(rng.uniform(0, 7));
      const double reach = rng.uniform(0.5, 40.0);
      const double expected = brute_force(walls, o, d, reach);
      const double found = plan.cast(o, d, reach);
      if (std::isinf(expected)) {
        EXPECT_EQ(found, expected);
      } else {
        EXPECT_NEAR(found, expected, 1e-9);
      }
    }
  }
}

TEST(FloorPlan, NoRayPassesTheJointOfTwoWalls) {
  const int sides = 64;
  const FloorPlan plan = FloorPlan::from_segments(polygon({0, 0}, 5.0, sides)).value();
  for (int i = 0; i < sides; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / sides;
    EXPECT_NEAR(plan.cast({0, 0}, unit(angle), 10.0), 5.0, 1e-9);
  }
}

TEST(FloorPlan, AxisParallelRaysOnCellBordersAndFromOutside) {
  const FloorPlan plan = room(4.0, 4.0);
  for (double y : {0.5, 1.0, 1.5, 2.0, 3.5}) {
    EXPECT_EQ(plan.cast({2.0, y}, {1, 0}, 10.0), 2.0);
    EXPECT_EQ(plan.cast({2.0, y}, {-1, 0}, 10.0), 2.0);
    EXPECT_EQ(plan.cast({-3.0, y}, {1, 0}, 10.0), 3.0);
    EXPECT_EQ(plan.cast({-3.0, y}, {-1, 0}, 10.0), kInf);
  }
  EXPECT_EQ(plan.cast({2.0, 2.0}, {1, 0}, 1.9), kInf);
  EXPECT_EQ(plan.cast({NAN, 2.0}, {1, 0}, 9.0), kInf);
}

TEST(FloorPlan, ClearanceIsTheDistanceToTheNearestWall) {
  Rng rng(5);
  const FloorPlan plan = room(8.0, 5.0);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector2d p(rng.uniform(0, 8), rng.uniform(0, 5));
    const double nearest = std::min({p.x(), 8 - p.x(), p.y(), 5 - p.y()});
    const double found = plan.clearance(p, 1.0);
    if (nearest <= 1.0) {
      EXPECT_NEAR(found, nearest, 1e-12);
    } else {
      EXPECT_EQ(found, kInf);
    }
  }
}

TEST(FloorPlan, CellsBecomeTheirOutlines) {
  // Two cells side by side: one rectangle, 2 x 1 cells of half a metre, four walls.
  const CellMask mask{4, 3, 0.5, {0, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0, 0}};
  const FloorPlan plan = FloorPlan::from_cells(mask).value();
  ASSERT_EQ(plan.segments().size(), 4U);
  EXPECT_EQ(plan.lower_corner_m(), Eigen::Vector2d(0.5, 0.5));
  EXPECT_EQ(plan.upper_corner_m(), Eigen::Vector2d(1.5, 1.0));
}

TEST(FloorPlan, SolidCellsHaveNoWallBetweenThem) {
  const FloorPlan plan = FloorPlan::from_cells({2, 2, 1.0, {1, 1, 1, 1}}).value();
  EXPECT_EQ(plan.segments().size(), 4U);
  EXPECT_FALSE(plan.blocks({0.5, 0.5}, {1.5, 1.5}));
}

TEST(FloorPlan, RefusesInvalidWalls) {
  EXPECT_FALSE(FloorPlan::from_segments({}).has_value());
  const Segment good{{0, 0}, {1, 0}};
  for (const Segment& bad : {Segment{{0, 0}, {0, 0}}, Segment{{NAN, 0}, {1, 0}},
                             Segment{{0, 0}, {kInf, 0}}, Segment{{0, 0}, {1e9, 0}}}) {
    const auto plan = FloorPlan::from_segments({good, bad});
    ASSERT_FALSE(plan.has_value());
    EXPECT_NE(plan.error().message.find("wall 1"), std::string::npos);
  }
  EXPECT_FALSE(FloorPlan::from_cells({2, 2, 1.0, {1, 1, 1}}).has_value());
  EXPECT_FALSE(FloorPlan::from_cells({2, 2, 0.0, {1, 1, 1, 1}}).has_value());
  EXPECT_FALSE(FloorPlan::from_cells({2, 2, 1.0, {0, 0, 0, 0}}).has_value());
}

TEST(FindLeak, ClosedRoomHasNone) { EXPECT_FALSE(find_leak(room(6, 4), {1, 1}).has_value()); }

TEST(FindLeak, FindsAPointOutside) {
  // The right wall is missing between y = 2.0 and 2.3.
  const FloorPlan plan = FloorPlan::from_segments({{{0, 0}, {6, 0}},
                                                   {{6, 0}, {6, 2}},
                                                   {{6, 2.3}, {6, 4}},
                                                   {{6, 4}, {0, 4}},
                                                   {{0, 4}, {0, 0}}})
                             .value();
  const auto leak = find_leak(plan, {1, 1});
  ASSERT_TRUE(leak.has_value());
  EXPECT_NEAR(leak->x(), 6.0, 0.11);
  EXPECT_NEAR(leak->y(), 2.15, 0.16);
}

TEST(FindLeak, APointOutsideIsItsOwnLeak) {
  EXPECT_EQ(find_leak(room(6, 4), {9, 9}), Eigen::Vector2d(9, 9));
}

}  // namespace
}  // namespace wayfare::sim
