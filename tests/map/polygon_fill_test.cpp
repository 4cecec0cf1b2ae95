#include "map/raster.hpp"

#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>

namespace wayfare::detail {
namespace {

constexpr std::int64_t kOne = std::int64_t{1} << SubCellPoint::kBits;
constexpr double kDegree = std::numbers::pi / 180.0;

struct Ray {
  SubCellPoint end;
  double bearing_rad = 0.0;
};

/// Whether the half line from p to the left crosses a–b, the upper end excluded: exact, in
/// integers. Polygons that share an edge share its crossings, so a point on it is in one of them.
bool crosses_left_of(const SubCellPoint& p, SubCellPoint a, SubCellPoint b) {
  if (a.y > b.y) std::swap(a, b);
  if (p.y < a.y || p.y >= b.y) return false;
  // x of the edge at p.y, times (b.y − a.y).
  return a.x * (b.y - a.y) + (b.x - a.x) * (p.y - a.y) <= p.x * (b.y - a.y);
}

bool is_inside(const SubCellPoint& p, std::span<const SubCellPoint> polygon) {
  bool inside = false;
  for (std::size_t i = 0; i < polygon.size(); ++i)
    inside ^= crosses_left_of(p, polygon[i], polygon[(i + 1) % polygon.size()]);
  return inside;
}

/// A raster and its bits.
struct Window {
  RasterShape raster;
  std::int64_t rows;
  std::vector<std::uint64_t> bits;

  Window(Cell origin, std::ptrdiff_t stride, std::int64_t height)
      : raster{origin, stride},
        rows(height),
        bits(static_cast<std::size_t>(stride / 64 * height)) {}
  [[nodiscard]] SubCellPoint centre(std::int64_t row, std::int64_t column) const {
    return {(raster.origin.x + column) * kOne + kOne / 2,
            (raster.origin.y + row) * kOne + kOne / 2};
  }
  [[nodiscard]] int mark(std::int64_t row, std::int64_t column) const {
    const std::int64_t at = row * raster.stride + column;
    return static_cast<int>(bits[static_cast<std::size_t>(at / 64)] >> (at % 64) & 1);
  }
  void fill(std::span<const SubCellPoint> polygon) {
    for (std::size_t i = 0; i < polygon.size(); ++i)
      flip_along_edge(polygon[i], polygon[(i + 1) % polygon.size()], raster, bits);
    const auto words = static_cast<std::size_t>(raster.stride / 64);
    for (std::size_t y = 0; y < static_cast<std::size_t>(rows); ++y)
      running_parity(std::span(bits).subspan(y * words, words));
  }
};

TEST(RunningParity, EqualsTheParityUpToEachBit) {
  Rng rng(1);
  for (const std::size_t n : {1U, 2U, 5U, 16U}) {
    std::vector<std::uint64_t> bits(n), want(n);
    std::uint64_t parity = 0;
    for (std::size_t i = 0; i < n; ++i)
      for (int b = 0; b < 64; ++b) {
        const std::uint64_t bit = rng.below(2);
        parity ^= bit;
        bits[i] |= bit << b;
        want[i] |= parity << b;
      }
    running_parity(bits);
    EXPECT_EQ(bits, want);
  }
}

// Random polygons, also self-intersecting; every second one has its corners on centres and
// boundaries.
TEST(FlipAlongEdge, FillsThePolygonOfTheDefinition) {
  Rng rng(2);
  for (int round = 0; round < 400; ++round) {
    const std::int64_t unit = round % 2 == 0 ? 1 : kOne / 2;
    const auto any = [&](std::int64_t cells) {
      const auto n = static_cast<std::uint64_t>(cells * kOne / unit);
      return static_cast<std::int64_t>(rng.below(n)) * unit;
    };
    Window w({-20, 7}, 64, 30);
    std::vector<SubCellPoint> polygon(3 + rng.below(9));
    for (SubCellPoint& p : polygon) p = {-20 * kOne + any(48), 7 * kOne + any(30)};
    w.fill(polygon);
    for (std::int64_t y = 0; y < w.rows; ++y)
      for (std::int64_t x = 0; x < w.raster.stride; ++x)
        ASSERT_EQ(w.mark(y, x), is_inside(w.centre(y, x), polygon) ? 1 : 0)
            << "round " << round << ", " << x << ' ' << y;
  }
}

// A square divided into triangles at an interior point: each cell belongs to exactly one.
TEST(FlipAlongEdge, PolygonsThatShareEdgesShareNoCell) {
  Rng rng(3);
  for (int round = 0; round < 100; ++round) {
    const SubCellPoint corner[4] = {{0, 0}, {24 * kOne, 0}, {24 * kOne, 24 * kOne}, {0, 24 * kOne}};
    const std::int64_t unit = round % 2 == 0 ? 1 : kOne / 2;
    const auto any = [&] {
      return (1 + static_cast<std::int64_t>(rng.below(24 * kOne / unit - 1))) * unit;
    };
    const SubCellPoint middle{any(), any()};
    std::vector<int> times(24 * 24, 0);
    for (std::size_t i = 0; i < 4; ++i) {
      Window w({0, 0}, 64, 24);
      const SubCellPoint triangle[] = {middle, corner[i], corner[(i + 1) % 4]};
      w.fill(triangle);
      for (std::size_t c = 0; c < times.size(); ++c)
        times[c] += w.mark(static_cast<std::int64_t>(c / 24), static_cast<std::int64_t>(c % 24));
    }
    EXPECT_EQ(times, std::vector<int>(24 * 24, 1)) << "round " << round;
  }
}

std::vector<Ray> fan(std::span<const double> bearings_deg, double reach_cells = 10.0) {
  std::vector<Ray> rays;
  for (const double b : bearings_deg)
    rays.push_back(
        {SubCellPoint::of(
             reach_cells * Eigen::Vector2d(std::cos(b * kDegree), std::sin(b * kDegree)), 1.0),
         b * kDegree});
  return rays;
}

std::vector<std::uint8_t> neighbours(const std::vector<Ray>& rays, double gap_deg) {
  std::vector<std::uint8_t> has_next;
  find_neighbours(std::span<const Ray>(rays), {0, 0}, gap_deg * kDegree, has_next);
  return has_next;
}

TEST(FindNeighbours, AreTheNextBeamsWithinTheGap) {
  using Marks = std::vector<std::uint8_t>;
  const double left[] = {-60, -40, -10, 10, 60};
  EXPECT_EQ(neighbours(fan(left), 25), (Marks{1, 0, 1, 0, 0}));
  EXPECT_EQ(neighbours(fan(left), 45), (Marks{1, 1, 1, 0, 0}));  // the last has no next
  const double right[] = {60, 10, -10, -40, -60};
  EXPECT_EQ(neighbours(fan(right), 25), (Marks{0, 1, 0, 1, 0}));
  const double over_the_back[] = {150, 170, -170, -150};
  EXPECT_EQ(neighbours(fan(over_the_back), 25), (Marks{1, 1, 1, 0}));
  std::vector<double> all_round;
  for (int i = 0; i < 36; ++i) all_round.push_back(10.0 * i);
  EXPECT_EQ(neighbours(fan(all_round), 15), Marks(36, 1));  // the last is followed by the first
  for (int i = 0; i < 10; ++i) all_round.push_back(10.0 * i);
  const Marks round_again = neighbours(fan(all_round), 15);
  EXPECT_EQ(std::count(round_again.begin(), round_again.end(), 1), 36);
}

// The union of the triangles of neighbours, which do not overlap, by the definition above.
TEST(FillPolygon, MarksTheTrianglesOfNeighbours) {
  Rng rng(5);
  for (int round = 0; round < 50; ++round) {
    std::vector<double> bearings;
    for (double b = -170; b < 170; b += rng.uniform(2.0, 30.0)) bearings.push_back(b);
    std::vector<Ray> rays = fan(bearings);
    for (Ray& r : rays) {
      const double part = rng.uniform(0.2, 2.3);
      r.end = {static_cast<std::int64_t>(part * static_cast<double>(r.end.x)),
               static_cast<std::int64_t>(part * static_cast<double>(r.end.y))};
    }
    const auto has_next = neighbours(rays, 20.0);
    Window w({-24, -24}, 64, 48);
    fill_polygon(std::span<const Ray>(rays), std::span<const std::uint8_t>(has_next), {0, 0},
                 w.raster, w.rows, std::span(w.bits));
    for (std::int64_t y = 0; y < w.rows; ++y) {
      for (std::int64_t x = 0; x < w.raster.stride; ++x) {
        int want = 0;
        for (std::size_t i = 0; i + 1 < rays.size(); ++i) {
          const SubCellPoint triangle[] = {{0, 0}, rays[i].end, rays[i + 1].end};
          if (has_next[i] != 0) want += is_inside(w.centre(y, x), triangle) ? 1 : 0;
        }
        ASSERT_EQ(w.mark(y, x), want) << "round " << round << ", " << x << ' ' << y;
      }
    }
  }
}

}  // namespace
}  // namespace wayfare::detail
