#pragma once

// Correlative scan matching: exhaustive, and by branch and bound.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include <wayfare/map/detail/precomputation_grids.hpp>
#include <wayfare/map/likelihood_field.hpp>
#include <wayfare/match/scan_matcher.hpp>

namespace wayfare {

/// The objective (scaled Σ ln p plus log prior, nats) of every candidate of a window.
struct ScoreSurface {
  int half_x = 0,             ///< half extent along x, cells
      half_y = 0,             ///< along y, cells
      half_heading = 0;       ///< heading steps
  double resolution_m = 0.0;  ///< m, side of a cell
  Angle heading_step;         ///< between neighbouring headings
  SE2d prior;                 ///< pose of the candidate (0, 0, 0)
  /// [heading][y][x], each from −half to +half.
  std::vector<double> log_score;

  /// Objective of a candidate, which must be within the extents.
  [[nodiscard]] double at(const Candidate& c) const {
    const int row = (c.heading_step + half_heading) * (2 * half_y + 1) + c.offset.y + half_y;
    return log_score[static_cast<std::size_t>(row) * static_cast<std::size_t>(2 * half_x + 1) +
                     static_cast<std::size_t>(c.offset.x + half_x)];
  }
};

/// Correlative scan matching (Olson 2009) by exhaustive search: every whole-cell offset
/// in the window at every heading; heading steps divide the window evenly and are at most
/// acos(1 − r²/2d²), which moves the farthest point (d) by one cell (r). Maximises
/// Σ ln p + log prior; ties go to the smallest x² + y² + k² (cells, steps), then the smallest
/// (k, y, x). Reuses its scratch memory: one matcher per thread.
class CorrelativeMatcher {
 public:
  using Map = LikelihoodField;  ///< the map it matches to
  /// Largest number of candidates of a window.
  static constexpr std::int64_t kMaxCandidates = std::int64_t{1} << 30;
  /// For score surfaces and covariances, which store every candidate.
  static constexpr std::int64_t kMaxSurface = std::int64_t{1} << 24;

  /// The best candidate at or above min_score. Errors: those of ScanMatcher.
  Result<std::optional<MatchResult>> match(const LikelihoodField& grid, const PointSet& points,
                                           const SE2d& prior, const SearchWindow& window,
                                           const MatchOptions& options = {});
  /// The objective of every candidate, at most kMaxSurface of them. Errors: those of ScanMatcher.
  Result<ScoreSurface> surface(const LikelihoodField& grid, const PointSet& points,
                               const SE2d& prior, const SearchWindow& window,
                               const MatchOptions& options = {});

 private:
  std::vector<std::int32_t> u_, v_, index_;
  std::vector<std::uint32_t> sums_;  // of every candidate
};

static_assert(ScanMatcher<CorrelativeMatcher>);

namespace detail {

/// The points by heading, in the units of a precomputation grid, those of one unit merged.
struct MergedPoints {
  int parts = 0;                   // per heading
  std::size_t used = 0;            // entries
  std::vector<std::size_t> first;  // entry of each heading
  std::vector<std::int32_t> x, y, ends;
  std::vector<std::uint16_t> weight;
};

}  // namespace detail

/// Branch and bound for the same optimum as CorrelativeMatcher: bounds over blocks of offsets, best
/// first, refined to single cells (after Hess et al. 2016). For large windows (loop closure), and
/// for many small ones with one map. A high `min_score` makes rejections fast. The covariance is
/// that of a window of ±8 cells and ±8 heading steps about the match. Reuses its scratch memory:
/// one matcher per thread.
class BranchAndBoundMatcher {
 public:
  using Map = PrecomputationGrids;  ///< maxima over blocks of cells: the bounds
  /// Largest number of candidates of a window.
  static constexpr std::int64_t kMaxCandidates = std::int64_t{1} << 34;

  /// The best candidate at or above min_score. Errors: those of ScanMatcher.
  Result<std::optional<MatchResult>> match(const PrecomputationGrids& map, const PointSet& points,
                                           const SE2d& prior, const SearchWindow& window,
                                           const MatchOptions& options = {});

 private:
  /// Up to four adjacent nodes along x.
  struct Row {
    double bound;
    Candidate corner;                   // of the first node
    std::array<std::uint32_t, 4> sums;  // upper bounds of the sums, in sixteenths
    unsigned members;                   // bit mask of the nodes
    int level;
  };
  /// Sixteen squares of 4×4 offsets at one heading, bounded by the first `seen` points.
  struct Group {
    Candidate corner;
    float c, s;  // cosine and sine, cells per metre
    int seen;
    std::uint32_t top;
    std::uint32_t sums[16];
  };
  struct Search;
  struct SmallSearch;

  std::vector<std::int32_t> u_, v_, index_;
  std::vector<float> x_, y_, copy_;  // the points in the order of their use
  std::array<detail::MergedPoints, PrecomputationGrids::kLevels> merged_;
  std::array<std::vector<Row>, PrecomputationGrids::kLevels> rows_, batch_;
  std::vector<Group> groups_;
  std::vector<std::int32_t> order_;
  std::vector<std::pair<int, int>> fit_;
  CorrelativeMatcher local_;
};

static_assert(ScanMatcher<BranchAndBoundMatcher>);

}  // namespace wayfare
