#include "trials.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <optional>

#include <wayfare/core/random.hpp>
#include <wayfare/core/statistics.hpp>
#include <wayfare/map/inverse_lidar.hpp>
#include <wayfare/match/correlative.hpp>
#include <wayfare/match/gauss_newton.hpp>
#include <wayfare/match/registration.hpp>

namespace wayfare::examples {
namespace {

using Clock = std::chrono::steady_clock;

double microseconds_since(Clock::time_point start) {
  return std::chrono::duration<double, std::micro>(Clock::now() - start).count();
}

/// The reference scan in the forms the matchers use.
struct Reference {
  const LaserScan& scan;
  PointSet points;
  PlacedPoints placed{&points, SE2d()};

  Reference(const LaserScan& s, double max_range_m)
      : scan(s), points(thin(end_points(s), 0.02F, static_cast<float>(max_range_m))) {}
  Reference(const Reference&) = delete;
  Reference& operator=(const Reference&) = delete;
};

/// Correlative search by branch and bound, refined between the cells.
struct Correlative {
  static constexpr const char* kName = "correlative, refined";
  struct Map {
    LikelihoodField grid;
    PrecomputationGrids pyramid;
  };
  BranchAndBoundMatcher matcher;

  static Result<Map> map(const Reference& r) {
    auto grid = likelihood_field({&r.placed, 1}, {0.05, 0.1, 0.01});
    if (!grid) return grid.error();
    PrecomputationGrids pyramid(*grid);
    return Map{std::move(*grid), std::move(pyramid)};
  }
  std::optional<SE2d> match(const Map& map, const PointSet& points, const SE2d& prior,
                            const SearchWindow& window) {
    const auto found = matcher.match(map.pyramid, points, prior, window);
    if (!found || !*found) return std::nullopt;
    const auto refined = refine(map.grid, points, (*found)->T_map_points);
    return refined ? refined->T_map_points : (*found)->T_map_points;
  }
};

/// A matcher of the library with the options given.
template <class Matcher>
struct LocalMatch {
  using Map = typename Matcher::Map;
  Matcher matcher;

  std::optional<SE2d> match(const Map& map, const PointSet& points, const SE2d& prior,
                            const SearchWindow& window) {
    const auto found = matcher.match(map, points, prior, window);
    if (!found || !*found) return std::nullopt;
    return (*found)->T_map_points;
  }
};

template <Interpolation kInterpolation, int kLevels>
struct GaussNewton : LocalMatch<GaussNewtonMatcher> {
  static constexpr const char* kName = kInterpolation == Interpolation::bilinear
                                           ? "Gauss-Newton, bilinear, three grids"
                                           : "least squares, bicubic, one grid";
  GaussNewton()
      : LocalMatch{GaussNewtonMatcher({.interpolation = kInterpolation, .max_iterations = 20})} {}

  static Result<Map> map(const Reference& r) {
    Map pyramid;
    for (int level = kLevels - 1; level >= 0; --level) {
      OccupancyGrid grid({.resolution_m = 0.05 * (1 << level)});
      ScanRaster raster;
      if (auto ok = insert_scan(grid, SE2d(), r.scan, {}, raster); !ok) return ok.error();
      if (auto ok = pyramid.emplace_back().make(grid, 0.1); !ok) return ok.error();
    }
    return pyramid;
  }
};

struct Icp : LocalMatch<IcpMatcher> {
  static constexpr const char* kName = "ICP, point to line";
  static Result<Map> map(const Reference& r) { return SurfaceMap::make({&r.placed, 1}); }
};

struct Ndt : LocalMatch<NdtMatcher> {
  static constexpr const char* kName = "NDT";
  static Result<Map> map(const Reference& r) { return NdtMap::make({&r.placed, 1}); }
};

/// The initial pose, the same for every matcher.
SE2d start_of(const ScanPair& pair, const StartError& error, Rng rng) {
  const double direction = rng.uniform(-std::numbers::pi, std::numbers::pi),
               side = rng.uniform() < 0.5 ? -1 : 1;
  return SE2d(
      Eigen::Vector2d(pair.T_reference_scan.translation() +
                      error.offset_m * Eigen::Vector2d(std::cos(direction), std::sin(direction))),
      pair.T_reference_scan.rotation() * SO2d(error.turn * side));
}

template <class Matcher>
class Trials {
 public:
  explicit Trials(const TrialOptions& options) : options_(options) {
    result_.name = Matcher::kName;
    result_.success.resize(options.starts.size());
    result_.microseconds.resize(options.starts.size());
  }

  void add(const ScanPair& pair, std::size_t index) {
    const Reference reference(*pair.reference, options_.max_range_m);
    const PointSet points =
        thin(end_points(*pair.scan), 0.02F, static_cast<float>(options_.max_range_m));
    ++pairs_;
    const auto begin = Clock::now();
    const auto map = Matcher::map(reference);
    result_.map_us += microseconds_since(begin);
    if (!map || points.empty()) return;
    for (std::size_t k = 0; k < options_.starts.size(); ++k) {
      const StartError& error = options_.starts[k];
      const SE2d start = start_of(pair, error, Rng(options_.seed).stream(index).stream(k));
      // A tenth more than the initial error.
      const double reach = 1.1 * error.offset_m + 0.1;
      const SearchWindow window{reach, reach, error.turn * 1.1 + Angle::degrees(2)};
      const auto match_begin = Clock::now();
      const auto found = matcher_.match(*map, points, start, window);
      result_.microseconds[k] += microseconds_since(match_begin);
      if (!found) continue;
      const SE2d off = pair.T_reference_scan.inverse() * *found;
      if (off.translation().norm() > options_.near_m ||
          std::abs(off.heading().radians()) > options_.near_turn.radians())
        continue;
      result_.success[k] += 1;
      if (k == 0) errors_m_.push_back(off.translation().norm());
    }
  }

  MatcherTrials result() {
    MatcherTrials r = result_;
    for (double& s : r.success) s /= pairs_;
    for (double& t : r.microseconds) t /= pairs_;
    r.map_us /= pairs_;
    r.median_error_m = median_of(errors_m_);
    return r;
  }

 private:
  TrialOptions options_;
  Matcher matcher_;
  MatcherTrials result_;
  std::vector<double> errors_m_;
  double pairs_ = 0;
};

}  // namespace

std::vector<MatcherTrials> run_trials(const std::vector<ScanPair>& pairs,
                                      const TrialOptions& options,
                                      const std::function<void(double)>& progress) {
  Trials<Correlative> correlative(options);
  Trials<GaussNewton<Interpolation::bilinear, 3>> bilinear(options);
  Trials<GaussNewton<Interpolation::bicubic, 1>> bicubic(options);
  Trials<Icp> icp(options);
  Trials<Ndt> ndt(options);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    correlative.add(pairs[i], i);
    bilinear.add(pairs[i], i);
    bicubic.add(pairs[i], i);
    icp.add(pairs[i], i);
    ndt.add(pairs[i], i);
    progress(static_cast<double>(i + 1) / static_cast<double>(pairs.size()));
  }
  return {correlative.result(), bilinear.result(), bicubic.result(), icp.result(), ndt.result()};
}

}  // namespace wayfare::examples
