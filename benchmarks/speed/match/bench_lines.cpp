// Corridor walls from a scan, compared with a plain Hough transform. Only ratios within one run are
// meaningful.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <benchmark/benchmark.h>

#include <wayfare/match/lines.hpp>
#include <wayfare/sensors/point_set.hpp>
#include <wayfare/sim/worlds.hpp>

namespace wayfare {
namespace {

/// Scans of a furnished corridor from many poses, and the prediction of tracking for each.
struct Scans {
  std::vector<LaserScan> scans;
  std::vector<CorridorWalls> predicted;
};

Scans scans_of(std::size_t beams) {
  Scans all;
  Rng rng(3);
  std::vector<sim::Segment> walls;
  const sim::CorridorFurniture doors{.door_spacing_m = 3.0,
                                     .open_share = 0.4,
                                     .recess_m = 0.06,
                                     .boxes_per_m = 0.1,
                                     .people_per_m = 0.05};
  sim::append_furnished_wall({-30, -1.2}, {30, -1.2}, 0.5, doors, rng, walls);
  sim::append_furnished_wall({30, 1.2}, {-30, 1.2}, 0.5, doors, rng, walls);
  const auto plan = sim::FloorPlan::from_segments(walls);
  sim::Lidar2dParams lidar = sim::CorridorDriveParams::lms200();
  lidar.beams = beams;
  const double span = beams > 400 ? 270.0 : 180.0;
  lidar.first_bearing = Angle::degrees(-0.5 * span);
  lidar.bearing_step = Angle::degrees(span / static_cast<double>(beams - 1));
  for (int i = 0; i < 64; ++i) {
    const SE2d pose(rng.uniform(-15.0, 15.0), rng.uniform(-0.4, 0.4),
                    Angle::radians(rng.uniform(-0.3, 0.3)));
    all.scans.push_back(sim::simulate_scan(
        *plan, [&](LogTime) { return pose; }, {}, lidar, rng));
    CorridorWalls p;
    p.direction = Angle::radians(-pose.heading().radians() + rng.normal(0.0, 0.002));
    p.left = Wall{1.2 - pose.y()};
    p.right = Wall{-1.2 - pose.y()};
    p.covariance.diagonal() << 4e-6, 1e-4, 1e-4;
    all.predicted.push_back(p);
  }
  return all;
}

template <class Find>
void over_scans(benchmark::State& state, const Find& find) {
  const Scans all = scans_of(static_cast<std::size_t>(state.range(0)));
  std::size_t i = 0, found = 0, tried = 0;
  for (auto _ : state) {
    found += find(all, i) ? 1 : 0;
    ++tried;
    i = (i + 1) % all.scans.size();
  }
  state.counters["found"] = static_cast<double>(found) / static_cast<double>(tried);
}

void Acquire(benchmark::State& state) {
  WallDetector detector;
  over_scans(state, [&](const Scans& s, std::size_t i) {
    return detector.acquire(s.scans[i]).has_value();
  });
}
void Track(benchmark::State& state) {
  WallDetector detector;
  over_scans(state, [&](const Scans& s, std::size_t i) {
    return detector.track(s.scans[i], s.predicted[i]).has_value();
  });
}
void FitWindows(benchmark::State& state) {
  WallDetector detector;
  over_scans(state, [&](const Scans& s, std::size_t i) {
    return detector.fit_windows(s.scans[i]).has_value();
  });
}
void Search(benchmark::State& state) {
  WallDetector detector;
  over_scans(state, [&](const Scans& s, std::size_t i) {
    return detector.search(s.scans[i]).has_value();
  });
}

/// Every point votes for all lines through it, at 0.2° and 1 cm, about the accuracy of the
/// detector; then the best cell. With `tables` the sines are looked up, else computed for each
/// vote.
void plain_hough(benchmark::State& state, bool tables) {
  constexpr int kAngles = 900, kOffsets = 2400;
  std::vector<double> cosine, sine;
  for (int a = 0; a < kAngles; ++a) {
    cosine.push_back(std::cos(a * std::numbers::pi / kAngles));
    sine.push_back(std::sin(a * std::numbers::pi / kAngles));
  }
  std::vector<int> votes(kAngles * kOffsets);
  over_scans(state, [&](const Scans& s, std::size_t i) {
    std::fill(votes.begin(), votes.end(), 0);
    const PointSet points = end_points(s.scans[i]);
    for (std::size_t p = 0; p < points.size(); ++p) {
      const Eigen::Vector2d at = points[p].cast<double>();
      if (at.norm() > 12.0) continue;
      for (std::size_t a = 0; a < kAngles; ++a) {
        const double angle = static_cast<double>(a) * std::numbers::pi / kAngles;
        const double c = tables ? cosine[a] : std::cos(angle);
        const double offset = at.x() * c + at.y() * (tables ? sine[a] : std::sin(angle));
        ++votes[a * kOffsets + static_cast<std::size_t>(offset * 100.0 + 0.5 * kOffsets)];
      }
    }
    return *std::max_element(votes.begin(), votes.end()) > 10;
  });
}
void PlainHough(benchmark::State& state) { plain_hough(state, false); }
void HoughWithTables(benchmark::State& state) { plain_hough(state, true); }

BENCHMARK(Acquire)->Arg(181)->Arg(361)->Arg(541)->Unit(benchmark::kMicrosecond);
BENCHMARK(Track)->Arg(181)->Arg(361)->Arg(541)->Unit(benchmark::kMicrosecond);
BENCHMARK(FitWindows)->Arg(181)->Arg(361)->Arg(541)->Unit(benchmark::kMicrosecond);
BENCHMARK(Search)->Arg(181)->Arg(361)->Arg(541)->Unit(benchmark::kMicrosecond);
BENCHMARK(PlainHough)->Arg(181)->Arg(361)->Arg(541)->Unit(benchmark::kMicrosecond);

BENCHMARK(HoughWithTables)->Arg(181)->Arg(361)->Arg(541)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace wayfare
