// MRPT on the scene of bench_match: inserting scans into its occupancy grid, and its scoring of a
// scan against a likelihood field, which its matchers call for every candidate.

#include <algorithm>
#include <cmath>
#include <vector>

#include <benchmark/benchmark.h>
#include <mrpt/maps/COccupancyGridMap2D.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/poses/CPose2D.h>
#include <mrpt/poses/CPose3D.h>

#include "scene.hpp"

namespace wayfare {
namespace {

mrpt::poses::CPose2D pose_of(const SE2d& T) { return {T.x(), T.y(), T.heading().radians()}; }

mrpt::obs::CObservation2DRangeScan observation(const LaserScan& scan) {
  mrpt::obs::CObservation2DRangeScan out;
  const std::size_t n = scan.ranges_m.size();
  out.aperture = static_cast<float>(scan.bearing_step.radians() * static_cast<double>(n - 1));
  out.rightToLeft = true;
  out.maxRange = scan.max_range_m;
  // MRPT's scans are symmetric about their axis: ours are rotated by the middle bearing.
  const Angle middle = scan.bearing(0) + scan.bearing_step * (0.5 * static_cast<double>(n - 1));
  out.sensorPose = mrpt::poses::CPose3D(0, 0, 0, middle.radians(), 0, 0);
  out.resizeScan(n);
  for (std::size_t i = 0; i < n; ++i) {
    out.setScanRange(i, scan.ranges_m[i]);
    out.setScanRangeValidity(i, true);
  }
  return out;
}

void grid_update(benchmark::State& state, float sides) {
  mrpt::maps::COccupancyGridMap2D grid(-sides, sides, -sides, sides, 0.05F);
  grid.insertionOptions.maxDistanceInsertion = 30;
  std::vector<mrpt::obs::CObservation2DRangeScan> scans;
  std::vector<mrpt::poses::CPose3D> poses;
  for (std::size_t i = 0; i < scene().scans.size(); ++i) {
    scans.push_back(observation(scene().scans[i]));
    poses.emplace_back(pose_of(scene().poses[i]));
  }
  std::size_t i = 0;
  for (auto _ : state) {
    i = (i + 1) % scans.size();
    benchmark::DoNotOptimize(grid.insertObservation(scans[i], poses[i]));
  }
  // The middle of the room is free.
  if (grid.getPos(0, 0) < 0.7F) state.SkipWithError("MRPT's grid does not show the room");
}
BENCHMARK_CAPTURE(grid_update, Mrpt, 10.0F)
    ->Name("grid_update/mrpt")
    ->Unit(benchmark::kMicrosecond);

void small_window(benchmark::State& state) {
  mrpt::maps::COccupancyGridMap2D grid(-10, 10, -10, 10, 0.05F);
  grid.likelihoodOptions.likelihoodMethod =
      mrpt::maps::COccupancyGridMap2D::lmLikelihoodField_Thrun;
  grid.likelihoodOptions.LF_decimation = 1;
  grid.likelihoodOptions.LF_stdHit = 0.1F;
  for (std::size_t i = 0; i < 20; ++i)
    grid.insertObservation(observation(scene().scans[i]),
                           mrpt::poses::CPose3D(pose_of(scene().poses[i])));
  mrpt::maps::CSimplePointsMap points;
  for (std::size_t i = 0; i < scene().seen.size(); ++i)
    points.insertPoint(scene().seen[i].x(), scene().seen[i].y(), 0);
  const SE2d& prior = scene().prior;
  // The headings of wayfare's search.
  const double finest = 2 * std::asin(0.025 / static_cast<double>(scene().seen.max_norm_m()));
  const int steps = static_cast<int>(std::ceil(kSmall.half_heading.radians() / finest));
  const double turn = kSmall.half_heading.radians() / steps;
  double candidates = 0;
  for (auto _ : state) {
    double best = -1e300;
    candidates = 0;
    for (int k = -steps; k <= steps; ++k)
      for (int y = -6; y <= 6; ++y)
        for (int x = -6; x <= 6; ++x, ++candidates) {
          const mrpt::poses::CPose2D pose(prior.x() + 0.05 * x, prior.y() + 0.05 * y,
                                          prior.heading().radians() + k * turn);
          best = std::max(best, grid.computeLikelihoodField_Thrun(&points, &pose));
        }
    benchmark::DoNotOptimize(best);
  }
  state.counters["candidates"] = candidates;
}
BENCHMARK(small_window)->Name("small_window/mrpt_likelihood_field")->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace wayfare
