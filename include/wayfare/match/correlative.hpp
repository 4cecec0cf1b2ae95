#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <wayfare/map/likelihood_field.hpp>
#include <wayfare/match/scan_matcher.hpp>

namespace wayfare {

/// The objective (scaled Σ ln p plus log prior, nats) of every candidate of a window.
struct ScoreSurface {
  int half_x = 0, half_y = 0, half_heading = 0;  ///< in cells and heading steps
  double resolution_m = 0.0;
  Angle heading_step;
  SE2d prior;
  /// [heading][y][x], each from −half to +half.
  std::vector<double> log_score;

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
  using Map = LikelihoodField;
  static constexpr std::int64_t kMaxCandidates = std::int64_t{1} << 30;
  /// For score surfaces and covariances, which store every candidate.
  static constexpr std::int64_t kMaxSurface = std::int64_t{1} << 24;

  Result<std::optional<MatchResult>> match(const LikelihoodField& grid, const PointSet& points,
                                           const SE2d& prior, const SearchWindow& window,
                                           const MatchOptions& options = {});
  Result<ScoreSurface> surface(const LikelihoodField& grid, const PointSet& points,
                               const SE2d& prior, const SearchWindow& window,
                               const MatchOptions& options = {});

 private:
  std::vector<std::int32_t> u_, v_, index_;
  std::vector<double> surface_;
};

static_assert(ScanMatcher<CorrelativeMatcher>);

}  // namespace wayfare
