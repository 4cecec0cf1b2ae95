// Distance transform and ray casting, compared with plain implementations, on the demo's building
// at 5 cm. Only ratios within one run are meaningful.

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <benchmark/benchmark.h>

#include <wayfare/core/random.hpp>
#include <wayfare/map/cell.hpp>
#include <wayfare/map/distance_field.hpp>
#include <wayfare/sim/floor_plan.hpp>

namespace wayfare {
namespace {

struct Map {
  int width = 0, height = 0;
  std::vector<std::uint8_t> occupied;
  DistanceField field;
  std::vector<SE2d> poses;  // in free space

  [[nodiscard]] bool at(int x, int y) const {
    return occupied[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                    static_cast<std::size_t>(x)] != 0;
  }
};

constexpr double kCell = 0.05, kReach = 30.0;

const Map& building() {
  static const Map map = [] {
    const auto planned = sim::read_plan(sim::demo_building());
    const Eigen::Vector2d low = planned->plan.lower_corner_m(),
                          high = planned->plan.upper_corner_m();
    Map m;
    m.width = static_cast<int>((high.x() - low.x()) / kCell) + 3;
    m.height = static_cast<int>((high.y() - low.y()) / kCell) + 3;
    m.occupied.resize(static_cast<std::size_t>(m.width) * static_cast<std::size_t>(m.height));
    for (const sim::Segment& s : planned->plan.segments())
      for_each_cell_on_segment(
          Eigen::Vector2d(s.a_m - low), Eigen::Vector2d(s.b_m - low), kCell,
          [&](const Cell& c) { m.occupied[static_cast<std::size_t>(c.y * m.width + c.x)] = 1; });
    m.field = *DistanceField::of_mask(m.occupied, m.width, m.height, kCell);
    Rng rng(1);
    while (m.poses.size() < 200) {
      const SE2d pose(rng.uniform(0.0, m.width * kCell), rng.uniform(0.0, m.height * kCell),
                      Angle::radians(rng.uniform(-3.0, 3.0)));
      if (m.field.distance_m(cell_of(pose.translation(), kCell)) > 0.3) m.poses.push_back(pose);
    }
    return m;
  }();
  return map;
}

/// Felzenszwalb and Huttenlocher's two passes of lower envelopes, plainly, in float.
void envelope_line(const float* f, int n, float* out, std::vector<int>& v, std::vector<float>& z) {
  constexpr float kInf = std::numeric_limits<float>::infinity();
  int k = 0;
  v[0] = 0;
  z[0] = -kInf;
  z[1] = kInf;
  for (int q = 1; q < n; ++q) {
    const auto meet = [&](int p) {
      return ((f[q] + static_cast<float>(q * q)) - (f[p] + static_cast<float>(p * p))) /
             static_cast<float>(2 * q - 2 * p);
    };
    float s = meet(v[static_cast<std::size_t>(k)]);
    while (s <= z[static_cast<std::size_t>(k)]) s = meet(v[static_cast<std::size_t>(--k)]);
    ++k;
    v[static_cast<std::size_t>(k)] = q;
    z[static_cast<std::size_t>(k)] = s;
    z[static_cast<std::size_t>(k) + 1] = kInf;
  }
  k = 0;
  for (int q = 0; q < n; ++q) {
    while (z[static_cast<std::size_t>(k) + 1] < static_cast<float>(q)) ++k;
    const int p = v[static_cast<std::size_t>(k)];
    out[q] = static_cast<float>((q - p) * (q - p)) + f[p];
  }
}

void transform_felzenszwalb(const Map& m, std::vector<float>& d) {
  const auto longest = static_cast<std::size_t>(std::max(m.width, m.height));
  std::vector<float> line(longest), out(longest), z(longest + 1);
  std::vector<int> v(longest);
  const auto w = static_cast<std::size_t>(m.width);
  for (std::size_t i = 0; i < d.size(); ++i) d[i] = m.occupied[i] != 0 ? 0.0F : 1e12F;
  for (std::size_t x = 0; x < w; ++x) {
    for (std::size_t y = 0; y < static_cast<std::size_t>(m.height); ++y) line[y] = d[y * w + x];
    envelope_line(line.data(), m.height, out.data(), v, z);
    for (std::size_t y = 0; y < static_cast<std::size_t>(m.height); ++y) d[y * w + x] = out[y];
  }
  for (std::size_t y = 0; y < static_cast<std::size_t>(m.height); ++y) {
    std::copy_n(d.data() + y * w, w, line.data());
    envelope_line(line.data(), m.width, d.data() + y * w, v, z);
  }
}

void per_megapixel(benchmark::State& state) {
  const Map& m = building();
  state.counters["ms_per_Mpx"] = benchmark::Counter(
      1e-9 * static_cast<double>(m.occupied.size()),
      benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void distances_wayfare(benchmark::State& state) {
  const Map& m = building();
  for (auto _ : state)
    benchmark::DoNotOptimize(DistanceField::of_mask(m.occupied, m.width, m.height, kCell));
  per_megapixel(state);
}
BENCHMARK(distances_wayfare)->Name("distance_transform/wayfare")->Unit(benchmark::kMillisecond);

void distances_felzenszwalb(benchmark::State& state) {
  const Map& m = building();
  std::vector<float> d(m.occupied.size());
  for (auto _ : state) {
    transform_felzenszwalb(m, d);
    benchmark::DoNotOptimize(d.data());
  }
  per_megapixel(state);
}
BENCHMARK(distances_felzenszwalb)
    ->Name("distance_transform/felzenszwalb")
    ->Unit(benchmark::kMillisecond);

constexpr int kRays = 64;
struct Bearings {
  std::vector<float> cosines, sines;
  Bearings() {
    for (int i = 0; i < kRays; ++i) {
      const double b = 2.0 * std::numbers::pi * i / kRays;
      cosines.push_back(static_cast<float>(std::cos(b)));
      sines.push_back(static_cast<float>(std::sin(b)));
    }
  }
};

/// Exact traversal in double precision to where the first occupied cell is entered.
double traverse(const Map& m, double x, double y, double c, double s, double limit) {
  int u = static_cast<int>(std::floor(x)), v = static_cast<int>(std::floor(y));
  const int step_u = c > 0.0 ? 1 : -1, step_v = s > 0.0 ? 1 : -1;
  const double dx = c != 0.0 ? std::abs(1.0 / c) : 1e18, dy = s != 0.0 ? std::abs(1.0 / s) : 1e18;
  double tx = (c > 0.0 ? u + 1 - x : x - u) * dx, ty = (s > 0.0 ? v + 1 - y : y - v) * dy, t = 0.0;
  while (t < limit) {
    if (u < 0 || v < 0 || u >= m.width || v >= m.height) return limit;
    if (m.at(u, v)) return t;
    if (tx < ty) {
      t = tx;
      tx += dx;
      u += step_u;
    } else {
      t = ty;
      ty += dy;
      v += step_v;
    }
  }
  return limit;
}

/// Plain sphere tracing, ray by ray, to within a cell.
double trace(const Map& m, double x, double y, double c, double s, double limit) {
  double t = 0.0;
  while (t < limit) {
    const Cell cell{static_cast<int>(std::floor(x + t * c)),
                    static_cast<int>(std::floor(y + t * s))};
    const std::int32_t square = m.field.squared_cells(cell);
    if (square == DistanceField::kFar) return limit;
    if (square == 0) return t;
    t += std::max(std::sqrt(static_cast<double>(square)) - 1.0, 0.5);
  }
  return limit;
}

template <class Cast>
void one_by_one(benchmark::State& state, const Cast& cast) {
  const Map& m = building();
  double sum = 0.0;
  int far = 0;
  for (auto _ : state) {
    for (const SE2d& pose : m.poses)
      for (int i = 0; i < kRays; ++i) {
        const double heading = pose.heading().radians() + 2.0 * std::numbers::pi * i / kRays;
        sum += cast(m, pose.x() / kCell, pose.y() / kCell, std::cos(heading), std::sin(heading));
        ++far;
      }
    benchmark::DoNotOptimize(sum);
  }
  const double rays = static_cast<double>(m.poses.size()) * kRays;
  state.counters["ns_per_ray"] = benchmark::Counter(
      1e-9 * rays, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
  state.counters["mean_cells"] = sum / far;
}

void rays_wayfare(benchmark::State& state) {
  const Map& m = building();
  const RayCaster caster(m.field);
  const Bearings b;
  std::vector<float> ranges(kRays);
  double sum = 0.0;
  for (auto _ : state) {
    for (const SE2d& pose : m.poses) {
      caster.cast(pose, b.cosines, b.sines, kReach, ranges);
      for (const float r : ranges) sum += static_cast<double>(r);
    }
    benchmark::DoNotOptimize(sum);
  }
  int off = 0, far_off = 0;
  for (const SE2d& pose : m.poses) {
    caster.cast(pose, b.cosines, b.sines, kReach, ranges);
    for (int i = 0; i < kRays; ++i) {
      const double heading = pose.heading().radians() + 2.0 * std::numbers::pi * i / kRays;
      const double exact = traverse(m, pose.x() / kCell, pose.y() / kCell, std::cos(heading),
                                    std::sin(heading), kReach / kCell);
      const double e =
          std::abs(static_cast<double>(ranges[static_cast<std::size_t>(i)]) / kCell - exact);
      off += e > 0.1 ? 1 : 0;
      far_off += e > 3.0 ? 1 : 0;
    }
  }
  const double rays = static_cast<double>(m.poses.size()) * kRays;
  state.counters["ns_per_ray"] = benchmark::Counter(
      1e-9 * rays, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
  state.counters["percent_off_a_tenth"] = 100.0 * off / rays;
  state.counters["percent_off_3_cells"] = 100.0 * far_off / rays;
}
BENCHMARK(rays_wayfare)->Name("ray_casting/wayfare")->Unit(benchmark::kMicrosecond);

void rays_exact(benchmark::State& state) {
  one_by_one(state, [](const Map& m, double x, double y, double c, double s) {
    return traverse(m, x, y, c, s, kReach / kCell);
  });
}
BENCHMARK(rays_exact)->Name("ray_casting/exact_traversal")->Unit(benchmark::kMicrosecond);

/// The library's traversal of a segment, always to its end.
void rays_segment(benchmark::State& state) {
  one_by_one(state, [](const Map& m, double x, double y, double c, double s) {
    const double limit = kReach / kCell;
    const Eigen::Vector2d from(x, y), to(x + limit * c, y + limit * s);
    double hit = limit;
    for_each_cell_on_segment(from, to, 1.0, [&](const Cell& at) {
      if (hit < limit || at.x < 0 || at.y < 0 || at.x >= m.width || at.y >= m.height) return;
      if (m.at(at.x, at.y)) hit = (Eigen::Vector2d(at.x + 0.5, at.y + 0.5) - from).norm();
    });
    return hit;
  });
}
BENCHMARK(rays_segment)->Name("ray_casting/segment_walk")->Unit(benchmark::kMicrosecond);

void rays_traced(benchmark::State& state) {
  one_by_one(state, [](const Map& m, double x, double y, double c, double s) {
    return trace(m, x, y, c, s, kReach / kCell);
  });
}
BENCHMARK(rays_traced)->Name("ray_casting/plain_sphere_tracing")->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace wayfare
