// Loop closure: scans searched in submaps of real logs that contain them or not, compared with
// plain branch and bound (Hess et al. 2016, algorithm 3, with its seven precomputed grids). The
// counter `differ` is the number of searches with different results.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>

#include <wayfare/core/random.hpp>
#include <wayfare/io/carmen.hpp>
#include <wayfare/match/correlative.hpp>

namespace wayfare {
namespace {

constexpr SearchWindow kWindow{7, 7, Angle::degrees(30)};
constexpr double kLeastScore = 0.68;

/// Maxima of a grid over windows of 2^level cells that begin at each; windows that begin up to
/// `margin` cells before the grid reach into it.
struct MaxGrid {
  int width = 0, height = 0, margin = 0;
  std::vector<std::uint16_t> table;

  [[nodiscard]] int at(int x, int y) const {
    x += margin, y += margin;
    if (x < 0 || y < 0 || x >= width || y >= height) return 0;
    return table[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                 static_cast<std::size_t>(x)];
  }
};

MaxGrid max_grid(const LikelihoodField& grid, int level) {
  const int size = 1 << level;
  MaxGrid result{grid.width() + size - 1, grid.height() + size - 1, size - 1, {}};
  std::vector<std::uint16_t> rows(static_cast<std::size_t>(result.width) *
                                  static_cast<std::size_t>(grid.height()));
  const auto cell = [&](int x, int y) {
    return static_cast<std::uint16_t>(grid.value(Cell{x, y} + grid.origin()));
  };
  for (int y = 0; y < grid.height(); ++y)
    for (int x = 0; x < result.width; ++x) {
      std::uint16_t most = 0;
      for (int k = std::max(0, x - size + 1); k <= std::min(x, grid.width() - 1); ++k)
        most = std::max(most, cell(k, y));
      rows[static_cast<std::size_t>(y) * static_cast<std::size_t>(result.width) +
           static_cast<std::size_t>(x)] = most;
    }
  result.table.resize(static_cast<std::size_t>(result.width) *
                      static_cast<std::size_t>(result.height));
  for (int y = 0; y < result.height; ++y)
    for (int x = 0; x < result.width; ++x) {
      std::uint16_t most = 0;
      for (int k = std::max(0, y - size + 1); k <= std::min(y, grid.height() - 1); ++k)
        most = std::max(most,
                        rows[static_cast<std::size_t>(k) * static_cast<std::size_t>(result.width) +
                             static_cast<std::size_t>(x)]);
      result.table[static_cast<std::size_t>(y) * static_cast<std::size_t>(result.width) +
                   static_cast<std::size_t>(x)] = most;
    }
  return result;
}

class PlainBranchAndBound {
 public:
  static constexpr int kLevels = 7;

  explicit PlainBranchAndBound(const LikelihoodField& grid)
      : resolution_m_(grid.resolution_m()), origin_(grid.origin()) {
    for (int level = 0; level < kLevels; ++level) levels_.push_back(max_grid(grid, level));
  }

  /// The largest sum of at least `least`, if any.
  std::optional<std::int64_t> match(const PointSet& points, const SE2d& prior,
                                    std::int64_t least) const {
    const std::vector<std::vector<Cell>> rotated = rotate(points, prior);
    const int half = static_cast<int>(std::ceil(kWindow.half_x_m / resolution_m_ - 1e-9));
    constexpr int kTop = kLevels - 1;
    std::vector<Node> nodes;
    for (std::size_t k = 0; k < rotated.size(); ++k)
      for (int y = -half; y <= half; y += 1 << kTop)
        for (int x = -half; x <= half; x += 1 << kTop) nodes.push_back({k, x, y, 0});
    score(nodes, rotated, kTop);
    std::int64_t best = least - 1;
    search(nodes, rotated, kTop, half, best);
    return best >= least ? std::optional(best) : std::nullopt;
  }

 private:
  struct Node {
    std::size_t heading = 0;
    int x = 0, y = 0;
    std::int64_t sum = 0;
  };

  [[nodiscard]] std::vector<std::vector<Cell>> rotate(const PointSet& points,
                                                      const SE2d& prior) const {
    const double finest =
        2 * std::asin(0.5 * resolution_m_ / static_cast<double>(points.max_norm_m()));
    const int steps = static_cast<int>(std::ceil(kWindow.half_heading.radians() / finest));
    const double step = kWindow.half_heading.radians() / steps, scale = 1.0 / resolution_m_;
    const auto ox = static_cast<float>(prior.x() * scale - origin_.x);
    const auto oy = static_cast<float>(prior.y() * scale - origin_.y);
    std::vector<std::vector<Cell>> rotated;
    for (int k = -steps; k <= steps; ++k) {
      const double heading = prior.heading().radians() + k * step;
      const auto c = static_cast<float>(std::cos(heading) * scale);
      const auto s = static_cast<float>(std::sin(heading) * scale);
      std::vector<Cell>& cells = rotated.emplace_back();
      for (std::size_t i = 0; i < points.size(); ++i) {
        const float x = points.x_m()[i], y = points.y_m()[i];
        cells.push_back({static_cast<int>(std::floor(c * x - s * y + ox)),
                         static_cast<int>(std::floor(s * x + c * y + oy))});
      }
    }
    return rotated;
  }

  void score(std::vector<Node>& nodes, const std::vector<std::vector<Cell>>& rotated,
             int level) const {
    const MaxGrid& grid = levels_[static_cast<std::size_t>(level)];
    for (Node& node : nodes) {
      node.sum = 0;
      for (const Cell& c : rotated[node.heading]) node.sum += grid.at(c.x + node.x, c.y + node.y);
    }
    std::stable_sort(nodes.begin(), nodes.end(),
                     [](const Node& a, const Node& b) { return a.sum > b.sum; });
  }

  void search(const std::vector<Node>& nodes, const std::vector<std::vector<Cell>>& rotated,
              int level, int half, std::int64_t& best) const {
    for (const Node& node : nodes) {
      if (node.sum <= best) return;
      if (level == 0) {
        best = node.sum;
        return;
      }
      std::vector<Node> parts;
      const int step = 1 << (level - 1);
      for (const int dy : {0, step})
        for (const int dx : {0, step})
          if (node.x + dx <= half && node.y + dy <= half)
            parts.push_back({node.heading, node.x + dx, node.y + dy, 0});
      score(parts, rotated, level - 1);
      search(parts, rotated, level - 1, half, best);
    }
  }

  double resolution_m_;
  Cell origin_;
  std::vector<MaxGrid> levels_;
};

struct Submap {
  PrecomputationGrids ours;
  PlainBranchAndBound plain;
};

struct Query {
  std::size_t submap = 0;
  PointSet points;
  SE2d prior;
};

struct Problems {
  std::vector<Submap> submaps;
  std::vector<Query> inside, outside;
};

/// Six submaps of forty scans, evenly distributed over a log; in each, two of its scans are
/// searched, from up to 5 m and 25° away, and two of other submaps.
Problems from_log(const std::string& name) {
  Problems problems;
  const std::string path = std::string(WAYFARE_DATA_DIR) + "/slam2d/" + name;
  if (!std::filesystem::exists(path)) return problems;
  const auto log = io::read_carmen(path);
  if (!log || log->reported_poses.size() != log->recording.scans.size()) return problems;
  constexpr std::size_t kSubmaps = 6, kScans = 40;
  const std::size_t apart = log->recording.scans.size() / kSubmaps;
  const auto points_of = [&](std::size_t i) { return end_points(log->recording.scans[i]); };
  const auto pose_of = [&](std::size_t i) { return log->reported_poses[i].T_map_base.raw(); };
  Rng rng(6);
  for (std::size_t m = 0; m < kSubmaps; ++m) {
    std::vector<PointSet> points;
    std::vector<PlacedPoints> placed;
    for (std::size_t k = 0; k < kScans; ++k) points.push_back(points_of(m * apart + k));
    for (std::size_t k = 0; k < kScans; ++k) placed.push_back({&points[k], pose_of(m * apart + k)});
    const auto field = likelihood_field(placed);
    if (!field) return {};
    problems.submaps.push_back({PrecomputationGrids(*field), PlainBranchAndBound(*field)});
    for (const std::size_t own : {kScans / 4, 3 * kScans / 4}) {
      const SE2d off(rng.uniform(-5, 5), rng.uniform(-5, 5), Angle::degrees(rng.uniform(-25, 25)));
      problems.inside.push_back({m, points[own], pose_of(m * apart + own) * off});
      const std::size_t other = (m + 2 + own % 3) % kSubmaps;
      problems.outside.push_back(
          {m, points_of(other * apart + own), pose_of(m * apart + own) * off});
    }
  }
  return problems;
}

std::optional<double> ours(BranchAndBoundMatcher& matcher, const Submap& map, const Query& q) {
  const auto found =
      matcher.match(map.ours, q.points, q.prior, kWindow, {.min_score = kLeastScore});
  if (!found || !*found) return std::nullopt;
  return (*found)->score;
}

std::optional<double> plain(const Submap& map, const Query& q) {
  const double most = static_cast<double>(q.points.size()) * LikelihoodField::kMaxValue;
  const auto sum =
      map.plain.match(q.points, q.prior, static_cast<std::int64_t>(std::ceil(kLeastScore * most)));
  if (!sum) return std::nullopt;
  return static_cast<double>(*sum) / most;
}

/// Number of queries with different results.
int differences(const Problems& problems, const std::vector<Query>& queries) {
  BranchAndBoundMatcher matcher;
  int count = 0;
  for (const Query& q : queries) {
    const auto a = ours(matcher, problems.submaps[q.submap], q);
    const auto b = plain(problems.submaps[q.submap], q);
    count += a.has_value() != b.has_value() || (a && std::abs(*a - *b) > 1e-9) ? 1 : 0;
  }
  return count;
}

template <class Match>
void run(benchmark::State& state, const Problems& problems, const std::vector<Query>& queries,
         Match&& match) {
  if (queries.empty()) return state.SkipWithError("no such recording in WAYFARE_DATA_DIR");
  int found = 0;
  for (auto _ : state) {
    found = 0;
    for (const Query& q : queries) found += match(problems.submaps[q.submap], q) ? 1 : 0;
  }
  state.counters["searches"] = static_cast<double>(queries.size());
  state.counters["found"] = found;
}

void register_searches() {
  for (const char* log : {"intel", "fr079"}) {
    const auto problems = std::make_shared<Problems>(from_log(std::string(log) + ".clf.gz"));
    for (const bool inside : {true, false}) {
      const std::vector<Query>& queries = inside ? problems->inside : problems->outside;
      const std::string task =
          std::string("loop_search_") + log + (inside ? "_inside" : "_elsewhere");
      const auto add = [&](const std::string& by, auto&& body) {
        benchmark::RegisterBenchmark((task + "/" + by).c_str(), body)
            ->Unit(benchmark::kMillisecond);
      };
      add("wayfare", [problems, &queries](benchmark::State& state) {
        BranchAndBoundMatcher matcher;
        run(state, *problems, queries,
            [&](const Submap& map, const Query& q) { return ours(matcher, map, q); });
        state.counters["differ"] = differences(*problems, queries);
      });
      add("plain_branch_and_bound", [problems, &queries](benchmark::State& state) {
        run(state, *problems, queries,
            [](const Submap& map, const Query& q) { return plain(map, q); });
      });
    }
  }
}
const bool kRegistered = (register_searches(), true);

}  // namespace
}  // namespace wayfare
