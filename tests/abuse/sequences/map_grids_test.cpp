// Random inserts, refusals, copies and moves of occupancy grids, beside maps of cells with every
// ray traversed by clipping it to each cell.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>

#include "abuse/abuse.hpp"
#include "abuse/map_cases.hpp"

namespace wayfare::tests {
namespace {

/// A fraction with a positive denominator; numbers stay below 2³⁰.
struct Fraction {
  std::int64_t top, bottom;
  bool operator<(const Fraction& o) const { return top * o.bottom < o.top * bottom; }
};

/// The part of a segment from a to b (in sub-cells, along one axis) inside [low, low + 4096).
std::pair<Fraction, Fraction> inside(std::int64_t a, std::int64_t b, std::int64_t low) {
  constexpr std::int64_t kOne = 4096;
  if (a == b) {
    const bool in = a >= low && a < low + kOne;
    return {{0, 1}, {in ? 1 : 0, 1}};
  }
  const std::int64_t sign = b > a ? 1 : -1, d = (b - a) * sign;
  Fraction enter{(low - a) * sign, d}, leave{(low + kOne - a) * sign, d};
  if (leave < enter) std::swap(enter, leave);
  return {std::max(enter, Fraction{0, 1}), std::min(leave, Fraction{1, 1})};
}

/// The cells of both ends, and every cell with a piece of positive length.
std::set<Cell> cells_of(const SubCellPoint& a, const SubCellPoint& b) {
  std::set<Cell> cells{a.cell(), b.cell()};
  const auto [x0, x1] = std::minmax({a.cell().x, b.cell().x});
  const auto [y0, y1] = std::minmax({a.cell().y, b.cell().y});
  for (int x = x0; x <= x1; ++x)
    for (int y = y0; y <= y1; ++y) {
      const auto across = inside(a.x, b.x, std::int64_t{x} * 4096);
      const auto along = inside(a.y, b.y, std::int64_t{y} * 4096);
      if (std::max(across.first, along.first) < std::min(across.second, along.second))
        cells.insert({x, y});
    }
  return cells;
}

/// Log-odds of the observed cells.
struct Model {
  std::map<Cell, int> cells;
  int low = 0, high = 0;

  void add(const Cell& c, int delta) {
    int& l = cells.try_emplace(c, 0).first->second;
    l = std::clamp(l + delta, low, high);
  }
  struct Ray {
    SubCellPoint end;
    bool hit;
  };
  void insert(const SubCellPoint& from, const std::vector<Ray>& rays, const InverseLidarModel& m,
              bool once) {
    const int free = LogOdds::from_probability(m.p_free).fixed;
    const int occupied = LogOdds::from_probability(m.p_hit).fixed;
    std::map<Cell, int> passes, hits;
    for (const Ray& ray : rays) {
      for (const Cell& c : cells_of(from, ray.end)) ++passes[c];
      if (ray.hit) ++hits[ray.end.cell()];
    }
    for (const auto& [c, n] : passes)
      if (!hits.contains(c) && free != 0) add(c, (once ? 1 : n) * free);
    for (const auto& [c, n] : hits)
      for (int i = 0; occupied != 0 && i < (once ? 1 : n); ++i) add(c, occupied);
  }
  [[nodiscard]] std::optional<CellBox> bounds() const {
    std::optional<CellBox> box;
    for (const auto& [c, l] : cells) {
      if (!box) box = {c, c};
      box->extend(c);
    }
    return box;
  }
};

struct Pair {
  OccupancyGrid grid;
  Model model;
};

void expect_equal(const Pair& p) {
  ASSERT_EQ(p.grid.bounds(), p.model.bounds());
  std::size_t observed_cells = 0;
  p.grid.for_each_tile([&](const Cell& corner, std::span<const std::int16_t> cells) {
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (cells[i] == OccupancyGrid::kUnknown) continue;
      ++observed_cells;
      const Cell c = corner + Cell{static_cast<int>(i % 64), static_cast<int>(i / 64)};
      const auto known = p.model.cells.find(c);
      ASSERT_TRUE(known != p.model.cells.end()) << c.x << " " << c.y;
      ASSERT_EQ(cells[i], known->second) << c.x << " " << c.y;
    }
  });
  ASSERT_EQ(observed_cells, p.model.cells.size());
}

/// Rows of a random box visit each observed cell once.
void expect_rows(const Pair& p, Rng& rng) {
  const auto coordinate = [&] { return static_cast<int>(rng.below(300)) - 150; };
  const Cell a{coordinate(), coordinate()};
  const CellBox box{a, a + Cell{static_cast<int>(rng.below(150)), static_cast<int>(rng.below(90))}};
  std::map<Cell, int> seen;
  p.grid.for_each_row(box, [&](const Cell& first, std::span<const std::int16_t> row) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      const Cell c = first + Cell{static_cast<int>(i), 0};
      ASSERT_TRUE(box.contains(c));
      if (row[i] == OccupancyGrid::kUnknown) continue;
      ASSERT_TRUE(seen.emplace(c, row[i]).second) << "visited twice";
    }
  });
  std::map<Cell, int> expected;
  for (const auto& entry : p.model.cells)
    if (box.contains(entry.first)) expected.insert(entry);
  ASSERT_EQ(seen, expected);
}

class Schedule {
 public:
  explicit Schedule(std::uint64_t seed) : rng_(seed) {
    const OccupancyGridOptions options{rng_.uniform() < 0.5 ? 0.1 : 0.25};
    for (Pair& p : pairs_) {
      p.grid = OccupancyGrid(options);
      p.model.low = LogOdds::from_probability(options.min_probability).fixed;
      p.model.high = LogOdds::from_probability(options.max_probability).fixed;
    }
  }
  void run(int calls) {
    for (int i = 0; i < calls && !::testing::Test::HasFatalFailure(); ++i) {
      step();
      for (const Pair& p : pairs_) expect_equal(p);
      expect_rows(pick(), rng_);
    }
    if (::testing::Test::HasFatalFailure()) ADD_FAILURE() << "after: " << log_.str();
  }

 private:
  Pair& pick() { return pairs_[rng_.below(pairs_.size())]; }
  template <class... Ts>
  void log(const Ts&... what) {
    (log_ << ... << what) << "; ";
  }

  void step() {
    switch (rng_.below(9)) {
      case 0:
        return update();
      case 1:
        return refused();
      case 2: {
        const std::size_t from = rng_.below(3), to = rng_.below(3);
        log("copy ", from, " to ", to);
        pairs_[to] = pairs_[from];
        return;
      }
      case 3: {
        const std::size_t from = rng_.below(3), to = (from + 1) % 3;
        log("move ", from, " to ", to);
        pairs_[to].grid = std::move(pairs_[from].grid);
        pairs_[to].model = pairs_[from].model;
        pairs_[from].model.cells.clear();
        return;
      }
      case 4:
      case 5:
        return points(rng_.uniform() < 0.5);
      default:
        return scan(rng_.uniform() < 0.5);
    }
  }
  void update() {
    Pair& p = pick();
    // Over the borders of tiles, and as far as cells are numbered.
    const int far = rng_.below(6) == 0 ? kMaxCell - 200 : 0;
    const Cell c{static_cast<int>(rng_.below(140)) - 70 + far,
                 static_cast<int>(rng_.below(140)) - 70 - far};
    const LogOdds delta{static_cast<std::int16_t>(rng_.below(6000) - 3000)};
    log("update ", c.x, " ", c.y, " ", delta.fixed);
    p.grid.update(c, delta);
    p.model.add(c, delta.fixed);
  }
  SE2d pose() {
    // On the corners of cells now and then.
    if (rng_.below(4) == 0)
      return {0.25 * static_cast<double>(rng_.below(20)), 0.0, Angle::degrees(90)};
    return {rng_.uniform(-3, 3), rng_.uniform(-3, 3), Angle::radians(rng_.uniform(-4, 4))};
  }
  InverseLidarModel model() {
    InverseLidarModel m;
    m.p_free = rng_.uniform(0.05, 0.6);
    m.p_hit = rng_.uniform(0.4, 0.95);
    m.max_usable_range_m = rng_.uniform(0.5, 3.0);
    m.free_range_without_return_m = rng_.below(2) == 0 ? 0.0 : rng_.uniform(0.0, 4.0);
    if (rng_.below(5) == 0) m.p_free = 0.5;  // nothing to add
    if (rng_.below(5) == 0) m.p_hit = 0.5;
    return m;
  }
  LaserScan random_scan() {
    LaserScan s;
    s.first_bearing = Angle::radians(rng_.uniform(-3, 3));
    s.bearing_step = Angle::radians(rng_.uniform(-0.5, 0.5));
    s.max_range_m = 5.0F;
    for (std::uint64_t n = rng_.below(12); n > 0; --n)
      s.ranges_m.push_back(rng_.below(5) == 0 ? static_cast<float>(kNotFinite[rng_.below(3)])
                                              : static_cast<float>(rng_.uniform(-0.5, 5.5)));
    return s;
  }
  void scan(bool once) {
    Pair& p = pick();
    const LaserScan s = random_scan();
    const InverseLidarModel m = model();
    const SE2d at = pose();
    const double resolution = p.grid.resolution_m();
    log("scan of ", s.ranges_m.size(), " at ", at.x(), " ", at.y());
    std::vector<Model::Ray> rays;
    for (std::size_t i = 0; i < s.ranges_m.size(); ++i) {
      const auto r = static_cast<double>(s.ranges_m[i]);
      const bool returned = r >= 0 && r < 5;
      const double range = returned ? r : m.free_range_without_return_m;
      if (!(range > 0)) continue;
      const double length = std::min(range, m.max_usable_range_m), b = s.bearing(i).radians();
      const Eigen::Vector2d end =
          at * Eigen::Vector2d(length * Eigen::Vector2d(std::cos(b), std::sin(b)));
      rays.push_back(
          {SubCellPoint::of(end, resolution), returned && range <= m.max_usable_range_m});
    }
    ASSERT_TRUE(once ? insert_scan<OncePerScan>(p.grid, at, s, m, raster_)
                     : insert_scan<EveryBeam>(p.grid, at, s, m, raster_));
    p.model.insert(SubCellPoint::of(at.translation(), resolution), rays, m, once);
  }
  void points(bool once) {
    Pair& p = pick();
    const InverseLidarModel m = model();
    const SE2d at = pose();
    const double resolution = p.grid.resolution_m();
    const Eigen::Vector2d origin(rng_.uniform(-0.3, 0.3), 0.0);
    PointSet set;
    std::vector<Model::Ray> rays;
    for (std::uint64_t n = rng_.below(10); n > 0; --n) {
      set.push_back(Eigen::Vector2d(rng_.uniform(-3, 3), rng_.uniform(-3, 3)).cast<float>());
      const Eigen::Vector2d beam = set[set.size() - 1].cast<double>() - origin;
      const double range = beam.norm(), scale = std::min(1.0, m.max_usable_range_m / range);
      const Eigen::Vector2d end = at * Eigen::Vector2d(origin + scale * beam);
      rays.push_back({SubCellPoint::of(end, resolution), range <= m.max_usable_range_m});
    }
    log(set.size(), " points at ", at.x(), " ", at.y());
    ASSERT_TRUE(once ? insert_points<OncePerScan>(p.grid, at, set, m, raster_, origin)
                     : insert_points<EveryBeam>(p.grid, at, set, m, raster_, origin));
    p.model.insert(SubCellPoint::of(at * origin, resolution), rays, m, once);
  }
  void refused() {
    Pair& p = pick();
    const std::uint64_t which = rng_.below(6);
    log("refused ", which);
    LaserScan s = random_scan();
    s.ranges_m.push_back(1.0F);
    InverseLidarModel m = model();
    PointSet set = points_at({{1.0F, 0.5F}, {0.2F, -1.0F}});
    SE2d at = pose();
    if (which == 0) at = SE2d(kNotFinite[rng_.below(3)], 0, Angle());
    if (which == 1) at = SE2d(1e12, 0, Angle());
    if (which == 2) m.p_hit = kNan;
    if (which == 3) m.fill_gap = Angle::radians(-1.0);
    if (which == 4) s.bearing_step = Angle::radians(kNotFinite[rng_.below(3)]);
    if (which >= 4) {
      m.max_usable_range_m = 1e9;
      set.push_back({which == 4 ? static_cast<float>(kNan) : 1e9F, 0.0F});
    }
    if (which == 5) {
      s.max_range_m = 2e9F;
      s.ranges_m.push_back(1e9F);
    }
    // Beams whose bearing is NaN end nowhere.
    ASSERT_FALSE(insert_scan<OncePerScan>(p.grid, at, s, m, raster_)) << which;
    ASSERT_FALSE(insert_scan<EveryBeam>(p.grid, at, s, m, raster_)) << which;
    ASSERT_FALSE(insert_scan<FillBetweenBeams>(p.grid, at, s, m, raster_)) << which;
    ASSERT_FALSE(insert_points<OncePerScan>(p.grid, at, set, m, raster_)) << which;
  }

  Rng rng_;
  std::array<Pair, 3> pairs_;
  ScanRaster raster_;
  std::ostringstream log_;
};

TEST(MapSequences, OccupancyGridsAreMapsOfCells) {
  for (std::uint64_t seed = 0; seed < 600; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Schedule(seed).run(12);
    if (HasFailure()) return;
  }
}

}  // namespace
}  // namespace wayfare::tests
