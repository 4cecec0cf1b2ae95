#pragma once

// Maps that the SLAM systems match scans to, for a matcher of any type.

#include <concepts>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <typeinfo>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/result.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/map/likelihood_field.hpp>
#include <wayfare/map/probability_grid.hpp>
#include <wayfare/match/scan_matcher.hpp>
#include <wayfare/sensors/point_set.hpp>

namespace wayfare {

namespace detail {

template <class M>
inline constexpr bool kMatchesProbabilities = requires {
  requires std::same_as<typename M::Map, ProbabilityPyramid>;
};

/// A matcher in occupancy probabilities, whose tables the systems keep themselves.
template <class M>
concept ProbabilityMatcher =
    ScanMatcher<M> && std::copy_constructible<M> && kMatchesProbabilities<M>;

}  // namespace detail

/// A matcher of submap and Hector SLAM: it makes its own maps (MappingMatcher), or matches in the
/// tables that the systems keep, with maps of type ProbabilityPyramid. Optional: `kName`, a static
/// text, its name in saved states; else they have that of the type.
template <class M>
concept SlamMatcher = ScanMatcher<M> && std::copy_constructible<M> &&
    requires(M matcher, std::span<const PlacedPoints> scans) {
  requires detail::kMatchesProbabilities<M> || requires {
    { matcher.make_map(scans) } -> std::same_as<Result<typename M::Map>>;
  };
};

namespace detail {

/// A map and its matcher, for one thread at a time.
class MatchedMap {
 public:
  virtual ~MatchedMap() = default;
  /// As of ScanMatcher; an Error also if there is no map.
  [[nodiscard]] virtual Result<std::optional<MatchResult>> match(const PointSet& points,
                                                                 const SE2d& prior,
                                                                 const SearchWindow& window,
                                                                 const MatchOptions& options) = 0;
  /// As far as the map's type tells.
  [[nodiscard]] virtual std::size_t memory_bytes() const = 0;
};

/// A map to which scans are added.
class GrowingMap : public MatchedMap {
 public:
  virtual Result<void> add(const SE2d& T_map_points, const PointSet& points) = 0;
  /// Whether wide windows must be searched from several headings: a matcher with maps of its own
  /// may converge only from nearby.
  [[nodiscard]] virtual bool is_local() const { return false; }
};

/// The map that a matcher makes of scans: when it is needed, or once of given ones.
template <MappingMatcher M>
class MadeMap final : public GrowingMap {
 public:
  explicit MadeMap(const M& matcher) : matcher_(matcher) {}
  MadeMap(const M& matcher, std::span<const PlacedPoints> scans)
      : matcher_(matcher), map_(matcher_.make_map(scans)) {}

  Result<void> add(const SE2d& T_map_points, const PointSet& points) override {
    points_.push_back(std::make_unique<PointSet>(points));
    scans_.push_back({points_.back().get(), T_map_points});
    map_.reset();
    return {};
  }
  [[nodiscard]] bool is_local() const override { return true; }
  Result<std::optional<MatchResult>> match(const PointSet& points, const SE2d& prior,
                                           const SearchWindow& window,
                                           const MatchOptions& options) override {
    if (!map_) map_.emplace(matcher_.make_map(scans_));
    if (!*map_) return map_->error();
    return matcher_.match(**map_, points, prior, window, options);
  }
  [[nodiscard]] std::size_t memory_bytes() const override {
    std::size_t bytes = 0;
    for (const auto& p : points_) bytes += 2 * sizeof(float) * p->size();
    if constexpr (requires(const typename M::Map& map) { map.memory_bytes(); })
      if (map_ && *map_) bytes += (**map_).memory_bytes();
    return bytes;
  }

 private:
  M matcher_;
  std::vector<std::unique_ptr<const PointSet>> points_;
  std::vector<PlacedPoints> scans_;
  std::optional<Result<typename M::Map>> map_;
};

/// Grids at several resolutions that every scan updates.
template <ProbabilityMatcher M>
class GridMap final : public GrowingMap {
 public:
  /// `origin`: of the scans' rays, in the points' axes.
  /// `raster`: scratch memory that maps of one thread share.
  GridMap(const M& matcher, const MultiResolutionOptions& options, const Eigen::Vector2d& origin,
          std::shared_ptr<ScanRaster> raster)
      : matcher_(matcher), grid_(options), origin_(origin), raster_(std::move(raster)) {}

  Result<void> add(const SE2d& T_map_points, const PointSet& points) override {
    return grid_.insert(T_map_points, points, origin_, *raster_);
  }
  Result<std::optional<MatchResult>> match(const PointSet& points, const SE2d& prior,
                                           const SearchWindow& window,
                                           const MatchOptions& options) override {
    return matcher_.match(grid_.tables(), points, prior, window, options);
  }
  [[nodiscard]] std::size_t memory_bytes() const override { return grid_.memory_bytes(); }

 private:
  M matcher_;
  MultiResolutionGrid grid_;
  Eigen::Vector2d origin_;
  std::shared_ptr<ScanRaster> raster_;
};

/// The tables of grids to which somebody else adds the scans.
template <ProbabilityMatcher M>
class GridView final : public GrowingMap {
 public:
  GridView(const M& matcher, const MultiResolutionGrid& grid) : matcher_(matcher), grid_(&grid) {}

  Result<void> add(const SE2d&, const PointSet&) override { return {}; }
  Result<std::optional<MatchResult>> match(const PointSet& points, const SE2d& prior,
                                           const SearchWindow& window,
                                           const MatchOptions& options) override {
    return matcher_.match(grid_->tables(), points, prior, window, options);
  }
  [[nodiscard]] std::size_t memory_bytes() const override { return 0; }

 private:
  M matcher_;
  const MultiResolutionGrid* grid_;
};

/// The finest grid, of `scans`. Scans that are too large are left out.
[[nodiscard]] OccupancyGrid grid_of(std::span<const PlacedPoints> scans,
                                    const MultiResolutionOptions& options,
                                    const Eigen::Vector2d& origin);
/// One table, of the cells that the points reach in the window; empty if no cell was observed.
[[nodiscard]] ProbabilityPyramid table_in_reach(const OccupancyGrid& grid,
                                                double unknown_probability, const PointSet& points,
                                                const SE2d& prior, const SearchWindow& window);
[[nodiscard]] std::size_t memory_bytes(const OccupancyGrid& grid);

/// A grid that does not change: a table of a part of it is made for each match, since tables
/// take several times the grid's memory.
template <ProbabilityMatcher M>
class FinishedGridMap final : public MatchedMap {
 public:
  FinishedGridMap(const M& matcher, OccupancyGrid grid, double unknown_probability)
      : matcher_(matcher), grid_(std::move(grid)), unknown_probability_(unknown_probability) {}

  Result<std::optional<MatchResult>> match(const PointSet& points, const SE2d& prior,
                                           const SearchWindow& window,
                                           const MatchOptions& options) override {
    return matcher_.match(table_in_reach(grid_, unknown_probability_, points, prior, window),
                          points, prior, window, options);
  }
  [[nodiscard]] std::size_t memory_bytes() const override { return detail::memory_bytes(grid_); }

 private:
  M matcher_;
  OccupancyGrid grid_;
  double unknown_probability_;
};

/// Of a matcher in saved states: its `kName`, or else that of the type.
template <class M>
[[nodiscard]] std::string matcher_name() {
  if constexpr (requires { std::string(M::kName); }) {
    return std::string(M::kName);
  } else {
#if defined(__cpp_rtti)
    return typeid(M).name();
#else
    static_assert(
        requires { std::string(M::kName); },
        "without RTTI a matcher needs its name in saved states, kName");
#endif
  }
}

/// Makes the maps of submap SLAM: of submaps that grow, which one thread uses, and of finished ones
/// for the refinement of loops, from several threads.
struct SubmapMaps {
  std::string matcher;  ///< its name
  std::function<std::unique_ptr<GrowingMap>()> growing;
  std::function<std::unique_ptr<MatchedMap>(std::span<const PlacedPoints>)> finished;
};

/// `origin`: of the scans' rays, in the points' axes.
template <SlamMatcher M>
[[nodiscard]] SubmapMaps submap_maps(const M& growing, const M& finished,
                                     const MultiResolutionOptions& grid,
                                     const Eigen::Vector2d& origin) {
  if constexpr (ProbabilityMatcher<M>) {
    return {matcher_name<M>(),
            [=, raster = std::make_shared<ScanRaster>()] {
              return std::make_unique<GridMap<M>>(growing, grid, origin, raster);
            },
            [=](std::span<const PlacedPoints> scans) {
              return std::make_unique<FinishedGridMap<M>>(finished, grid_of(scans, grid, origin),
                                                          grid.unknown_probability);
            }};
  } else {
    return {matcher_name<M>(), [=] { return std::make_unique<MadeMap<M>>(growing); },
            [=](std::span<const PlacedPoints> scans) {
              return std::make_unique<MadeMap<M>>(finished, scans);
            }};
  }
}

/// Makes the map of Hector SLAM, given the grids to which it adds every scan of the map as well.
using MakeHectorMap = std::function<std::unique_ptr<GrowingMap>(const MultiResolutionGrid&)>;

template <SlamMatcher M>
[[nodiscard]] MakeHectorMap hector_map(const M& matcher) {
  if constexpr (ProbabilityMatcher<M>) {
    return [=](const MultiResolutionGrid& grid) {
      return std::make_unique<GridView<M>>(matcher, grid);
    };
  } else {
    return [=](const MultiResolutionGrid&) { return std::make_unique<MadeMap<M>>(matcher); };
  }
}

}  // namespace detail
}  // namespace wayfare
