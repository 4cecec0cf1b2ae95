// Random inserts into grids of several resolutions, and makers that are reused, beside the plain
// grids and new makers.

#include <array>
#include <cmath>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>

#include "abuse/abuse.hpp"
#include "abuse/map_cases.hpp"

namespace wayfare::tests {
namespace {

/// Every table of a multi-resolution grid has the probabilities of its own occupancy grid, whatever
/// was refused in between.
TEST(MapSequences, TablesFollowTheirGrids) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Rng rng(seed);
    MultiResolutionOptions options;
    options.finest.resolution_m = 0.2;
    options.levels = 1 + static_cast<int>(rng.below(3));
    options.unknown_probability = rng.uniform();
    MultiResolutionGrid map(options);
    std::vector<OccupancyGrid> grids;  // coarse to fine
    for (int l = options.levels - 1; l >= 0; --l)
      grids.emplace_back(OccupancyGridOptions{0.2 * (1 << l)});
    ScanRaster raster;
    bool any = false;
    for (int call = 0; call < 10; ++call) {
      SCOPED_TRACE(call);
      const int k = static_cast<int>(rng.below(20));
      const double far = rng.below(4) == 0 ? 60.0 : 0.0;  // the tables grow
      const SE2d at(pose_in_room(k).x() + far, pose_in_room(k).y() - far,
                    pose_in_room(k).heading());
      LaserScan scan = scan_in_room(k);
      switch (rng.below(5)) {
        case 0:
          scan.ranges_m.assign(scan.ranges_m.size(),
                               static_cast<float>(kNotFinite[static_cast<std::size_t>(k) % 3]));
          ASSERT_TRUE(map.insert(at, scan)) << "without a return";
          break;
        case 1:
          ASSERT_FALSE(map.insert(SE2d(kNan, 0, Angle()), scan));
          break;
        case 2: {
          ASSERT_TRUE(map.insert(at, PointSet()));
          const MultiResolutionGrid copy = map;
          map = copy;
          break;
        }
        default:
          ASSERT_TRUE(map.insert(at, scan));
          for (OccupancyGrid& grid : grids)
            ASSERT_TRUE(insert_scan(grid, at, scan, options.model, raster));
          any = true;
      }
      ASSERT_EQ(map.empty(), !any);
      ASSERT_EQ(observed(map.finest()), observed(grids.back()));
      for (std::size_t l = 0; any && l < grids.size(); ++l) {
        const CellBox box = *grids[l].bounds();
        ASSERT_TRUE(map.tables()[l].covers(box));
        for (int i = 0; i < 2000; ++i) {
          const Cell c{
              box.min.x - 3 + static_cast<int>(rng.below(std::uint64_t(box.width() + 6))),
              box.min.y - 3 + static_cast<int>(rng.below(std::uint64_t(box.height() + 6)))};
          const double odds = std::exp(grids[l].log_odds(c).nats());
          const double p = grids[l].observed(c) ? odds / (1 + odds) : options.unknown_probability;
          ASSERT_EQ(map.tables()[l].value(c), std::lround(p * ProbabilityGrid::kOne));
        }
      }
    }
  }
}

/// Makers that are reused, with other options, other resolutions and refusals in between, give what
/// new ones give.
TEST(MapSequences, ReusedMakersAreAsNew) {
  const std::array<OccupancyGrid, 2> grids{room_grid(0.1), room_grid(0.07)};
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Rng rng(seed);
    OccupancyFieldMaker occupancy;
    DetectionFieldMaker detections;
    LikelihoodFieldMaker likelihood;
    LikelihoodField view;
    for (int call = 0; call < 8; ++call) {
      SCOPED_TRACE(call);
      const OccupancyGrid& grid = grids[rng.below(2)];
      PointSet points = points_in_room(static_cast<int>(rng.below(9)));
      SE2d pose = pose_in_room(static_cast<int>(rng.below(9)));
      const std::uint64_t fault = rng.below(12);
      if (fault == 0) points.push_back({static_cast<float>(kNan), 0.0F});
      if (fault == 1) points = PointSet();
      if (fault == 2) pose = SE2d(0, kInf, Angle());
      if (fault == 3) points.push_back({1e9F, -1e9F});
      const FieldReach reach{rng.uniform(0, 0.5), rng.uniform(0, 0.2)};
      const OccupancyFieldOptions o{fault == 4 ? kNan : rng.uniform(0.03, 0.2),
                                    rng.uniform(0.15, 0.5)};
      const DetectionViewOptions d{.hit_probability = rng.uniform(0.51, 0.9),
                                   .blur_sigma_m = fault == 4 ? kInf : rng.uniform(0, 0.2),
                                   .max_detections = rng.uniform(1, 50)};
      const LikelihoodFieldOptions l{grid.resolution_m(),
                                     fault == 4 ? 0.0 : rng.uniform(0.05, 0.2)};
      const PlacedPoints placed{&points, pose};
      const auto compare = [&](auto& reused, const auto& make_with) {
        std::decay_t<decltype(reused)> fresh;
        LikelihoodField expected;
        ASSERT_EQ(make_with(fresh, expected).has_value(), fault > 4);
        if (rng.below(4) == 0) {  // moved from, and used again
          const auto elsewhere = std::move(reused);
          ASSERT_EQ(make_with(reused, view).has_value(), fault > 4);
        }
        ASSERT_EQ(make_with(reused, view).has_value(), fault > 4);
        ASSERT_EQ(observed(view), observed(expected));
      };
      compare(occupancy, [&](OccupancyFieldMaker& maker, LikelihoodField& out) {
        return maker.make(grid, points, pose, reach, o, out);
      });
      compare(detections, [&](DetectionFieldMaker& maker, LikelihoodField& out) {
        return maker.make(grid, points, pose, reach, d, out);
      });
      compare(likelihood, [&](LikelihoodFieldMaker& maker, LikelihoodField& out) {
        return maker.make({&placed, 1}, l, out);
      });
      if (HasFailure()) return;
    }
  }
}

}  // namespace
}  // namespace wayfare::tests
