#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/map/inverse_lidar.hpp>
#include <wayfare/map/inverse_lidar_model.hpp>

namespace wayfare {
namespace {

constexpr double kCell_m = 0.05;

/// Twice the area of (a, b, c) in the lattice of SubCellPoint, positive counter-clockwise.
std::int64_t area(const SubCellPoint& a, const SubCellPoint& b, const SubCellPoint& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

enum class Place { outside, on_an_edge, inside };

Place place_of(const SubCellPoint& p, const SubCellPoint& a, const SubCellPoint& b,
               const SubCellPoint& c) {
  const std::int64_t u = area(a, b, p), v = area(b, c, p), w = area(c, a, p);
  if ((u > 0 && v > 0 && w > 0) || (u < 0 && v < 0 && w < 0)) return Place::inside;
  const bool mixed = (u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0);
  return mixed ? Place::outside : Place::on_an_edge;
}

struct Beam {
  SubCellPoint end;
  bool alone = true;
};

/// The beams that returned, and the sectors between neighbours (indices into them).
struct Fan {
  std::vector<Beam> beams;
  std::vector<std::pair<std::size_t, std::size_t>> sectors;
};

/// By beam number: consecutive beams, at most `gap` steps apart.
Fan fan_of(const LaserScan& scan, const SE2d& pose, std::size_t gap) {
  Fan fan;
  std::vector<std::size_t> number;
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    if (!scan.returned(i)) continue;
    const double b = scan.bearing(i).radians(), r = static_cast<double>(scan.ranges_m[i]);
    fan.beams.push_back(
        {SubCellPoint::of(pose * Eigen::Vector2d(r * std::cos(b), r * std::sin(b)), kCell_m)});
    number.push_back(i);
  }
  const double around = 2 * std::numbers::pi / std::abs(scan.bearing_step.radians());
  for (std::size_t i = 0; i < number.size(); ++i) {
    const std::size_t next = i + 1 == number.size() ? 0 : i + 1;
    const double apart = static_cast<double>(number[next]) - static_cast<double>(number[i]) +
                         (next == 0 ? around : 0.0);
    if (apart > static_cast<double>(gap) + 0.5) continue;
    fan.sectors.emplace_back(i, next);
    fan.beams[i].alone = fan.beams[next].alone = false;
  }
  return fan;
}

void expect_filled(const LaserScan& scan, const SE2d& pose, double gap_deg, std::size_t gap) {
  OccupancyGrid grid({kCell_m, 0.001, 0.999});
  ScanRaster raster;
  InverseLidarModel model;
  model.fill_gap = Angle::degrees(gap_deg);
  ASSERT_TRUE(insert_scan<FillBetweenBeams>(grid, pose, scan, model, raster));
  const Fan fan = fan_of(scan, pose, gap);
  const SubCellPoint origin = SubCellPoint::of(pose.translation(), kCell_m);
  std::vector<Cell> hits, passed;
  CellBox box{origin.cell(), origin.cell()};
  for (const Beam& beam : fan.beams) {
    hits.push_back(beam.end.cell());
    box.extend(hits.back());
    if (beam.alone)
      for_each_cell_on_segment(origin, beam.end, [&](const Cell& c) { passed.push_back(c); });
  }
  const auto holds = [](const std::vector<Cell>& cells, const Cell& c) {
    return std::find(cells.begin(), cells.end(), c) != cells.end();
  };
  for (int y = box.min.y - 2; y <= box.max.y + 2; ++y)
    for (int x = box.min.x - 2; x <= box.max.x + 2; ++x) {
      const Cell c{x, y};
      const SubCellPoint centre{std::int64_t{x} * 4096 + 2048, std::int64_t{y} * 4096 + 2048};
      Place place = holds(passed, c) ? Place::inside : Place::outside;
      for (const auto& [i, j] : fan.sectors)
        place = std::max(place, place_of(centre, origin, fan.beams[i].end, fan.beams[j].end));
      const int l = grid.log_odds(c).fixed;
      if (holds(hits, c)) {
        ASSERT_EQ(l, LogOdds::from_probability(0.9).fixed);
      } else if (place == Place::inside) {
        ASSERT_EQ(l, LogOdds::from_probability(0.2).fixed) << x << ' ' << y;
      } else if (place == Place::outside) {
        ASSERT_FALSE(grid.observed(c)) << x << ' ' << y;
      }
    }
}

/// Ranges that drift and jump, and missing returns.
LaserScan ragged(Rng& rng, int beams, double first_deg, double step_deg) {
  LaserScan scan;
  scan.first_bearing = Angle::degrees(first_deg);
  scan.bearing_step = Angle::degrees(step_deg);
  scan.max_range_m = 30;
  double range = 2;
  for (int i = 0; i < beams; ++i) {
    range = rng.uniform() < 0.1 ? rng.uniform(0.3, 4) : range + rng.normal(0, 0.02);
    const bool lost = rng.uniform() < 0.08;
    scan.ranges_m.push_back(lost ? 81.0F : static_cast<float>(std::max(0.1, range)));
  }
  return scan;
}

TEST(FillBetweenBeams, FreesTheCellsWithinTheTrianglesOfNeighbours) {
  Rng rng(12);
  for (int i = 0; i < 6; ++i) {
    SCOPED_TRACE(i);
    const SE2d pose(rng.uniform(-3, 3), rng.uniform(-3, 3), Angle::radians(rng.uniform(-3, 3)));
    expect_filled(ragged(rng, 181, -90, 1), pose, 1.5, 1);   // gaps stay open, some beams alone
    expect_filled(ragged(rng, 181, 90, -1), pose, 2.5, 2);   // clockwise
    expect_filled(ragged(rng, 360, -180, 1), pose, 2.5, 2);  // a full revolution
    expect_filled(ragged(rng, 60, -90, 3), pose, 2.5, 0);    // no neighbours at all
  }
}

TEST(FillBetweenBeams, AScanOfTwoRevolutionsFillsOnce) {
  LaserScan scan;
  scan.bearing_step = Angle::degrees(1);
  scan.max_range_m = 30;
  scan.ranges_m.assign(500, 2.0F);
  OccupancyGrid grid;
  ScanRaster raster;
  ASSERT_TRUE(insert_scan<FillBetweenBeams>(grid, SE2d(), scan, {}, raster));
  for (int y = -25; y <= 25; ++y)
    for (int x = -25; x <= 25; ++x)
      ASSERT_EQ(grid.log_odds({x, y}), LogOdds::from_probability(0.2)) << x << ' ' << y;
}

TEST(FillBetweenBeams, PointsInOrderEqualTheScan) {
  Rng rng(13);
  const LaserScan scan = ragged(rng, 181, -90, 1);
  const SE2d pose(0.3, -0.7, Angle::degrees(20));
  OccupancyGrid by_scan, by_points;
  ScanRaster raster;
  InverseLidarModel model;
  model.fill_gap = Angle::degrees(1.5);
  ASSERT_TRUE(insert_scan<FillBetweenBeams>(by_scan, pose, scan, model, raster));
  ASSERT_TRUE(insert_points<FillBetweenBeams>(by_points, pose, end_points(scan), model, raster));
  int differing = 0;  // points are single precision
  for (int y = -100; y <= 100; ++y)
    for (int x = -100; x <= 100; ++x)
      differing += by_scan.log_odds({x, y}) != by_points.log_odds({x, y});
  EXPECT_LT(differing, 10);
}

}  // namespace
}  // namespace wayfare
