// Scan matching and map building beside the plain ways to do them. Only ratios within one run
// count. The scene: 20 scans of 356 points of a 12 m × 9 m room with 40 boxes, 5 cm cells.

#include <algorithm>
#include <cmath>
#include <vector>

#include <benchmark/benchmark.h>

#include <wayfare/core/random.hpp>
#include <wayfare/map/inverse_lidar.hpp>
#include <wayfare/match/branch_and_bound.hpp>
#include <wayfare/match/correlative.hpp>
#include <wayfare/match/refine.hpp>

namespace wayfare {
namespace {

struct Box {
  Eigen::Vector2d low, high;
};

struct Scene {
  std::vector<LaserScan> scans;
  std::vector<PointSet> points;
  std::vector<SE2d> poses;
  std::vector<PlacedPoints> placed;
  MatchGrid field;
  PointSet seen;
  SE2d prior;

  Scene() {
    Rng rng(1);
    std::vector<Box> boxes;
    for (int i = 0; i < 40; ++i) {
      const Eigen::Vector2d p(rng.uniform(-5.5, 5.0), rng.uniform(-4.0, 3.8));
      if (p.norm() < 1.8) continue;
      boxes.push_back({p, p + Eigen::Vector2d(rng.uniform(0.1, 0.8), rng.uniform(0.1, 0.8))});
    }
    for (int i = 0; i < 21; ++i) {
      poses.emplace_back(rng.uniform(-1, 1), rng.uniform(-1, 1), Angle::radians(0.3 * i));
      scans.push_back(sweep(poses.back(), boxes, rng));
      points.push_back(end_points(scans.back()));
    }
    for (std::size_t i = 0; i < 20; ++i) placed.push_back({&points[i], poses[i]});
    field = *likelihood_field(placed);
    seen = points[20];
    prior = poses[20].plus({0.17, -0.11, 0.2});
  }

  static LaserScan sweep(const SE2d& pose, const std::vector<Box>& boxes, Rng& rng) {
    LaserScan scan;
    scan.first_bearing = Angle::degrees(-178);
    scan.bearing_step = Angle::degrees(1);
    scan.max_range_m = 30;
    for (int i = 0; i < 356; ++i) {
      const SO2d turn(pose.heading() + scan.first_bearing + scan.bearing_step * i);
      const Eigen::Vector2d d = turn * Eigen::Vector2d(1, 0), p = pose.translation();
      double range = exit({{-6, -4.5}, {6, 4.5}}, p, d).second;
      for (const Box& b : boxes) {
        const auto [in, out] = exit(b, p, d);
        if (in < out && in > 0) range = std::min(range, in);
      }
      scan.ranges_m.push_back(static_cast<float>(range + rng.normal(0, 0.01)));
    }
    return scan;
  }
  /// Where the ray enters and leaves the box.
  static std::pair<double, double> exit(const Box& b, const Eigen::Vector2d& p,
                                        const Eigen::Vector2d& d) {
    const Eigen::Array2d s = (b.low - p).array() / d.array(), t = (b.high - p).array() / d.array();
    return {s.min(t).maxCoeff(), s.max(t).minCoeff()};
  }
};

const Scene& scene() {
  static const Scene made;
  return made;
}
const SearchWindow kSmall{0.3, 0.3, Angle::degrees(20)};
const SearchWindow kLarge{7, 7, Angle::degrees(30)};

/// The same search candidate by candidate: points turned once a heading, padded table, no checks.
std::int64_t brute_force(const MatchGrid& grid, const PointSet& points, const SE2d& prior,
                         const SearchWindow& window) {
  const double r = grid.resolution_m();
  const int half = static_cast<int>(std::ceil(window.half_x_m / r - 1e-9));
  const double finest = 2 * std::asin(0.5 * r / static_cast<double>(points.max_norm_m()));
  const int steps = static_cast<int>(std::ceil(window.half_heading.radians() / finest));
  const double step = window.half_heading.radians() / steps;
  std::vector<const std::uint16_t*> at(points.size());
  std::int64_t best = -1;
  for (int k = -steps; k <= steps; ++k) {
    const SE2d pose(prior.x(), prior.y(), prior.heading() + Angle::radians(k * step));
    for (std::size_t i = 0; i < at.size(); ++i) {
      const Cell c = cell_of(pose * Eigen::Vector2d(points[i].cast<double>()), r) - grid.origin();
      at[i] = grid.data() +
              std::ptrdiff_t{std::clamp(c.y, -MatchGrid::kBorder / 2, grid.height() + 8)} *
                  grid.stride() +
              std::clamp(c.x, -MatchGrid::kBorder / 2, grid.width() + 8);
    }
    for (int y = -half; y <= half; ++y)
      for (int x = -half; x <= half; ++x) {
        const std::ptrdiff_t offset = std::ptrdiff_t{y} * grid.stride() + x;
        std::int64_t sum = 0;
        for (const std::uint16_t* p : at) sum += p[offset];
        best = std::max(best, sum);
      }
  }
  return best;
}

void BM_BruteForceSmall(benchmark::State& state) {
  for (auto _ : state)
    benchmark::DoNotOptimize(brute_force(scene().field, scene().seen, scene().prior, kSmall));
}
BENCHMARK(BM_BruteForceSmall)->Name("small_window/brute_force")->Unit(benchmark::kMicrosecond);

void BM_CorrelativeSmall(benchmark::State& state) {
  CorrelativeMatcher matcher;
  std::int64_t candidates = 0;
  for (auto _ : state)
    candidates = (**matcher.match(scene().field, scene().seen, scene().prior, kSmall)).candidates;
  state.counters["candidates"] = static_cast<double>(candidates);
}
BENCHMARK(BM_CorrelativeSmall)->Name("small_window/wayfare")->Unit(benchmark::kMicrosecond);

void BM_CorrelativeCovarianceSmall(benchmark::State& state) {
  CorrelativeMatcher matcher;
  MatchOptions options;
  options.covariance = true;
  options.independent_points = 40;
  for (auto _ : state)
    benchmark::DoNotOptimize(
        matcher.match(scene().field, scene().seen, scene().prior, kSmall, options));
}
BENCHMARK(BM_CorrelativeCovarianceSmall)
    ->Name("small_window/wayfare_covariance")
    ->Unit(benchmark::kMicrosecond);

void bounded(benchmark::State& state, const SearchWindow& window, double min_score) {
  const MaxPyramid pyramid(scene().field);
  BranchAndBoundMatcher matcher;
  MatchOptions options;
  options.min_score = min_score;
  for (auto _ : state)
    benchmark::DoNotOptimize(matcher.match(pyramid, scene().seen, scene().prior, window, options));
}
BENCHMARK_CAPTURE(bounded, Small, kSmall, 0.0)
    ->Name("small_window/branch_and_bound")
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(bounded, Large, kLarge, 0.0)
    ->Name("large_window/branch_and_bound")
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(bounded, LargeRejected, kLarge, 0.99)
    ->Name("large_window/branch_and_bound_rejected")
    ->Unit(benchmark::kMicrosecond);

void BM_CorrelativeLarge(benchmark::State& state) {
  CorrelativeMatcher matcher;
  for (auto _ : state)
    benchmark::DoNotOptimize(matcher.match(scene().field, scene().seen, scene().prior, kLarge));
}
BENCHMARK(BM_CorrelativeLarge)->Name("large_window/wayfare")->Unit(benchmark::kMicrosecond);

void BM_MaxPyramid(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(MaxPyramid(scene().field));
}
BENCHMARK(BM_MaxPyramid)->Unit(benchmark::kMicrosecond);

void BM_LikelihoodField(benchmark::State& state) {
  LikelihoodFieldMaker maker;
  MatchGrid grid;
  for (auto _ : state) benchmark::DoNotOptimize(maker.make(scene().placed, {}, grid));
}
BENCHMARK(BM_LikelihoodField)->Unit(benchmark::kMicrosecond);

void BM_Refine(benchmark::State& state) {
  const SE2d start = scene().poses[20].plus({0.02, -0.02, 0.004});
  for (auto _ : state) benchmark::DoNotOptimize(refine(scene().field, scene().seen, start));
}
BENCHMARK(BM_Refine)->Unit(benchmark::kMicrosecond);

template <class FreeSpace>
void BM_InsertScan(benchmark::State& state) {
  OccupancyGrid grid;
  ScanRaster raster;
  std::size_t i = 0;
  for (auto _ : state) {
    i = (i + 1) % scene().scans.size();
    benchmark::DoNotOptimize(
        insert_scan<FreeSpace>(grid, scene().poses[i], scene().scans[i], {}, raster));
  }
}
BENCHMARK_TEMPLATE(BM_InsertScan, OncePerScan)->Unit(benchmark::kMicrosecond);
BENCHMARK_TEMPLATE(BM_InsertScan, EveryBeam)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace wayfare
