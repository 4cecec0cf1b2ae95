// An occupancy grid from scans at known poses: two rooms with a door between them, simulated, and
// the map drawn in characters: # occupied, . free, blank unknown.
#include <cstdio>
#include <vector>

#include <wayfare/map/inverse_lidar.hpp>
#include <wayfare/map/occupancy_grid.hpp>
#include <wayfare/sim/floor_plan.hpp>

using namespace wayfare;

int main() {
  const auto plan =
      sim::FloorPlan::from_segments({{{0.25, 0.25}, {7.75, 0.25}},  // metres
                                     {{7.75, 0.25}, {7.75, 4.75}},
                                     {{7.75, 4.75}, {0.25, 4.75}},
                                     {{0.25, 4.75}, {0.25, 0.25}},
                                     {{4.25, 0.25}, {4.25, 3.00}}});  // the door is above
  if (!plan) return std::puts(plan.error().message.c_str()), 1;

  OccupancyGrid grid({.resolution_m = 0.5});
  const InverseLidarModel model;
  ScanRaster raster;  // scratch memory
  Rng rng(1);
  for (const SE2d& pose : {SE2d(1.5, 1.5, 0_deg), SE2d(2.5, 4.0, 45_deg), SE2d(6.0, 2.0, 90_deg)}) {
    const LaserScan scan = sim::simulate_scan(
        *plan, [&](LogTime) { return pose; }, LogTime(), sim::full_circle(720), rng);
    const Result<void> inserted = insert_scan(grid, pose, scan, model, raster);
    if (!inserted) return std::puts(inserted.error().message.c_str()), 1;
  }

  for (int y = 9; y >= 0; --y) {
    for (int x = 0; x < 16; ++x) {
      const Cell cell{x, y};
      const char free_or_occupied = grid.probability(cell) > 0.5 ? '#' : '.';
      std::putchar(grid.observed(cell) ? free_or_occupied : ' ');
    }
    std::putchar('\n');
  }
}
