// Scan matching and map building, compared with plain implementations. Only ratios within one run
// are meaningful. Cells of 5 cm.

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include <wayfare/io/carmen.hpp>
#include <wayfare/map/inverse_lidar.hpp>
#include <wayfare/match/correlative.hpp>
#include <wayfare/match/gauss_newton.hpp>

#include "scene.hpp"

namespace wayfare {
namespace {

/// The same search candidate by candidate: points rotated once per heading, padded table, no
/// checks.
std::int64_t brute_force(const LikelihoodField& grid, const PointSet& points, const SE2d& prior,
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
              std::ptrdiff_t{std::clamp(c.y, -LikelihoodField::kBorder / 2, grid.height() + 8)} *
                  grid.stride() +
              std::clamp(c.x, -LikelihoodField::kBorder / 2, grid.width() + 8);
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

/// A scan, the field of earlier scans, and the prior.
struct Problem {
  LikelihoodField field;
  PointSet seen;
  SE2d prior;
  PrecomputationGrids pyramid = PrecomputationGrids(field);
};
using Problems = std::vector<Problem>;

Problems room() { return {{scene().field, scene().seen, scene().prior}}; }

/// Twenty scans of a log, each with the field of the ten before it, at odometry poses.
Problems from_log(const std::string& name) {
  const std::string path = std::string(WAYFARE_DATA_DIR) + "/slam2d/" + name;
  Problems problems;
  if (!std::filesystem::exists(path)) return problems;
  const auto log = io::read_carmen(path);
  if (!log || log->reported_poses.size() != log->recording.scans.size()) return problems;
  const std::size_t n = log->recording.scans.size();
  Rng rng(5);
  for (std::size_t i = n / 25; i < n && problems.size() < 20; i += n / 21) {
    std::vector<PointSet> points;
    std::vector<PlacedPoints> placed;
    for (std::size_t j = i - 10; j <= i; ++j) points.push_back(end_points(log->recording.scans[j]));
    for (std::size_t j = 0; j < 10; ++j)
      placed.push_back({&points[j], log->reported_poses[i - 10 + j].T_map_base.raw()});
    const SE2d off(rng.uniform(-0.2, 0.2), rng.uniform(-0.2, 0.2),
                   Angle::degrees(rng.uniform(-12, 12)));
    if (auto field = likelihood_field(placed); field && !points.back().empty())
      problems.push_back({*field, points.back(), log->reported_poses[i].T_map_base.raw() * off});
  }
  return problems;
}

/// Runs `match(problem)` on all; the time is the sum.
template <class Match>
void run(benchmark::State& state, const Problems& problems, Match&& match) {
  if (problems.empty()) return state.SkipWithError("no such recording in WAYFARE_DATA_DIR");
  double points = 0;
  for (const Problem& p : problems)
    points += static_cast<double>(p.seen.size()) / static_cast<double>(problems.size());
  // Complete rounds, so that all problems have the same weight.
  for (auto _ : state)
    for (const Problem& p : problems) match(p);
  state.counters["problems"] = static_cast<double>(problems.size());
  state.counters["points"] = points;
}

void bounded(benchmark::State& state, const Problems& problems, const SearchWindow& window,
             double min_score = 0.0) {
  BranchAndBoundMatcher matcher;
  MatchOptions options;
  options.min_score = min_score;
  std::int64_t candidates = 0;
  run(state, problems, [&](const Problem& p) {
    const auto found = matcher.match(p.pyramid, p.seen, p.prior, window, options);
    if (*found) candidates = (*found)->candidates;
  });
  state.counters["candidates"] = static_cast<double>(candidates);
}

void bounded_with_pyramid(benchmark::State& state, const Problems& problems,
                          const SearchWindow& window) {
  BranchAndBoundMatcher matcher;
  run(state, problems, [&](const Problem& p) {
    benchmark::DoNotOptimize(matcher.match(PrecomputationGrids(p.field), p.seen, p.prior, window));
  });
}

void exhaustive(benchmark::State& state, const Problems& problems, const SearchWindow& window,
                bool covariance = false) {
  CorrelativeMatcher matcher;
  MatchOptions options;
  options.covariance = covariance;
  options.independent_points = covariance ? 40 : 0;
  run(state, problems, [&](const Problem& p) {
    benchmark::DoNotOptimize(matcher.match(p.field, p.seen, p.prior, window, options));
  });
}

void brute(benchmark::State& state, const Problems& problems, const SearchWindow& window) {
  run(state, problems, [&](const Problem& p) {
    benchmark::DoNotOptimize(brute_force(p.field, p.seen, p.prior, window));
  });
}

void register_matches() {
  const auto add = [](const std::string& name, auto&& body) {
    benchmark::RegisterBenchmark(name.c_str(), body)->Unit(benchmark::kMicrosecond);
  };
  const std::pair<const char*, Problems> sets[] = {
      {"", room()}, {"_intel", from_log("intel.clf.gz")}, {"_fr079", from_log("fr079.clf.gz")}};
  for (const auto& named : sets) {
    const std::string task = std::string("small_window") + named.first;
    const Problems& set = named.second;  // Clang 14 captures no structured bindings
    add(task + "/wayfare_bounded", [set](auto& s) { bounded(s, set, kSmall); });
    add(task + "/wayfare_bounded_and_pyramid",
        [set](auto& s) { bounded_with_pyramid(s, set, kSmall); });
    add(task + "/wayfare_exhaustive", [set](auto& s) { exhaustive(s, set, kSmall); });
    add(task + "/wayfare_exhaustive_covariance",
        [set](auto& s) { exhaustive(s, set, kSmall, true); });
    add(task + "/brute_force", [set](auto& s) { brute(s, set, kSmall); });
  }
  add("large_window/wayfare_bounded", [](auto& s) { bounded(s, room(), kLarge); });
  add("large_window/wayfare_bounded_rejected", [](auto& s) { bounded(s, room(), kLarge, 0.99); });
  add("large_window/wayfare_exhaustive", [](auto& s) { exhaustive(s, room(), kLarge); });
}
const bool kRegistered = (register_matches(), true);

void BM_PrecomputationGrids(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(PrecomputationGrids(scene().field));
}
BENCHMARK(BM_PrecomputationGrids)
    ->Name("precomputation_grids/wayfare")
    ->Unit(benchmark::kMicrosecond);

void BM_LikelihoodField(benchmark::State& state) {
  LikelihoodFieldMaker maker;
  LikelihoodField grid;
  for (auto _ : state) benchmark::DoNotOptimize(maker.make(scene().placed, {}, grid));
}
BENCHMARK(BM_LikelihoodField)->Name("likelihood_field/wayfare")->Unit(benchmark::kMicrosecond);

void BM_Refine(benchmark::State& state) {
  const SE2d start = scene().poses[20].plus({0.02, -0.02, 0.004});
  for (auto _ : state) benchmark::DoNotOptimize(refine(scene().field, scene().seen, start));
}
BENCHMARK(BM_Refine)->Name("refine/wayfare")->Unit(benchmark::kMicrosecond);

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
BENCHMARK_TEMPLATE(BM_InsertScan, OncePerScan)
    ->Name("grid_update/wayfare_once")
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_TEMPLATE(BM_InsertScan, EveryBeam)
    ->Name("grid_update/wayfare_every_beam")
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_TEMPLATE(BM_InsertScan, FillBetweenBeams)
    ->Name("grid_update/wayfare_fill")
    ->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace wayfare
