#include <wayfare/match/correlative.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <vector>

#include "map/kernels/kernels.hpp"
#include "match/local/registration.hpp"
#include "match/search/candidates.hpp"

namespace wayfare {
namespace detail {
namespace {

/// Number of steps of at most `step` in each half of ±half.
int half_steps(double half, double step) {
  if (half == 0) return 0;  // also for a step of zero
  return static_cast<int>(std::ceil(std::min(half / step, 1e6) - 1e-9));
}

/// acos(1 − r²/2d²), in a form that is accurate for far points.
double finest_heading_step(double farthest_m, double resolution_m) {
  const double half_chord = 0.5 * resolution_m / farthest_m;
  return half_chord < 1 ? 2 * std::asin(half_chord) : std::numbers::pi;  // also for d = 0
}

Eigen::Matrix3d along_map_axes(const Eigen::Matrix3d& information, const SE2d& prior) {
  const Eigen::Matrix3d symmetric = 0.5 * (information + information.transpose());
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  rotation.topLeftCorner<2, 2>() = prior.rotation().matrix();
  return rotation * symmetric * rotation.transpose();
}

/// Every sixteenth cosine and sine directly, that of the prior's heading included; those between by
/// the addition theorem, in double precision.
std::vector<Heading> headings_of(const CandidateSpace& s) {
  constexpr int kFine = 16;
  const double prior = s.prior.heading().radians(), inverse = 1.0 / s.resolution_m;
  double fine_c[kFine], fine_s[kFine], coarse_c = 1.0, coarse_s = 0.0;
  for (int i = 0; i < kFine; ++i) {
    fine_c[i] = std::cos(i * s.heading_step_rad);
    fine_s[i] = std::sin(i * s.heading_step_rad);
  }
  std::vector<Heading> headings;
  headings.reserve(2 * static_cast<std::size_t>(s.half_k) + 1);
  for (int k = -s.half_k; k <= s.half_k; ++k) {
    const int i = k & (kFine - 1);
    if (i == 0 || k == -s.half_k) {
      coarse_c = std::cos(prior + (k - i) * s.heading_step_rad) * inverse;
      coarse_s = std::sin(prior + (k - i) * s.heading_step_rad) * inverse;
    }
    headings.push_back({static_cast<float>(coarse_c * fine_c[i] - coarse_s * fine_s[i]),
                        static_cast<float>(coarse_s * fine_c[i] + coarse_c * fine_s[i])});
  }
  return headings;
}

}  // namespace

double CandidateSpace::log_prior_bound(const Candidate& corner, int side) const {
  if (!has_prior) return 0.0;
  // Concave in the offset: the maximum over the square is the unconstrained one or on an edge (a
  // parabola each). Slack for rounding.
  const double k = corner.heading_step * heading_step_rad;
  const double a = information(0, 0), b = information(0, 1), c = information(1, 1);
  const double fx = information(0, 2) * k, fy = information(1, 2) * k;
  const double x0 = corner.offset.x * resolution_m, x1 = x0 + (side - 1) * resolution_m;
  const double y0 = corner.offset.y * resolution_m, y1 = y0 + (side - 1) * resolution_m;
  const auto cost = [&](double x, double y) {
    return a * x * x + 2 * b * x * y + c * y * y + 2 * (fx * x + fy * y);
  };
  const auto best_x = [&](double y) { return a > 0 ? std::clamp(-(b * y + fx) / a, x0, x1) : x0; };
  const auto best_y = [&](double x) { return c > 0 ? std::clamp(-(b * x + fy) / c, y0, y1) : y0; };
  double least = std::min(
      {cost(x0, best_y(x0)), cost(x1, best_y(x1)), cost(best_x(y0), y0), cost(best_x(y1), y1)});
  const double det = a * c - b * b;
  if (det > 1e-12 * a * c) {
    const double x = (b * fy - c * fx) / det, y = (b * fx - a * fy) / det;
    if (x > x0 && x < x1 && y > y0 && y < y1) least = std::min(least, cost(x, y));
  }
  const double whole = least + information(2, 2) * k * k;
  const double scale =
      a * std::max(x0 * x0, x1 * x1) + c * std::max(y0 * y0, y1 * y1) + information(2, 2) * k * k;
  return std::min(0.0, -0.5 * whole + 1e-9 * scale);
}

Result<CandidateSpace> plan(const LikelihoodField& grid, const PointSet& points, const SE2d& prior,
                            const SearchWindow& window, const MatchOptions& options,
                            std::int64_t max_candidates) {
  if (grid.empty()) return Error{ErrorCode::invalid, "match: the map is empty"};
  if (auto ok = check_input("match", points, prior, window, options); !ok) return ok.error();
  if (points.size() > 400'000) return Error{ErrorCode::invalid, "match: more than 400000 points"};
  if (!(options.independent_points >= 0) || !(options.min_score <= 1))
    return Error{ErrorCode::invalid, "match: independent_points or min_score out of range"};
  CandidateSpace s{};
  s.resolution_m = grid.resolution_m();
  s.prior = prior;
  s.points = static_cast<int>(points.size());
  s.half_x = half_steps(window.half_x_m, s.resolution_m);
  s.half_y = half_steps(window.half_y_m, s.resolution_m);
  const double half_heading = std::min(window.half_heading.radians(), std::numbers::pi);
  s.half_k = half_steps(half_heading, finest_heading_step(points.max_norm_m(), s.resolution_m));
  s.heading_step_rad = s.half_k > 0 ? half_heading / s.half_k : 0.0;
  if (std::max({s.half_x, s.half_y, s.half_k}) > (1 << 16) || s.count() > max_candidates)
    return Error{ErrorCode::invalid,
                 "match: the search window has " +
                     std::to_string(static_cast<double>(s.half_x) * s.half_y * s.half_k * 8) +
                     " candidates, more than this matcher supports"};
  const double n = s.points, independent = options.independent_points;
  s.weight = grid.log_step() * (independent > 0 ? std::min(1.0, independent / n) : 1.0);
  s.min_sum = static_cast<std::int64_t>(
      std::ceil(std::max(0.0, options.min_score) * n * LikelihoodField::kMaxValue));
  if (options.prior_information) {
    s.information = along_map_axes(*options.prior_information, prior);
    s.has_prior = true;
  }
  s.headings = headings_of(s);
  return s;
}

kernels::CellTransform transform_of(const CandidateSpace& s, const LikelihoodField& grid, int k) {
  const Heading& h = s.headings[static_cast<std::size_t>(k + s.half_k)];
  const double inverse = 1.0 / s.resolution_m;
  return {h.c,
          h.s,
          static_cast<float>(s.prior.x() * inverse - grid.origin().x),
          static_cast<float>(s.prior.y() * inverse - grid.origin().y),
          1048576.0F,
          0,
          0};
}

void place(const CandidateSpace& s, const LikelihoodField& grid, const PointSet& points, int k,
           std::int32_t* u, std::int32_t* v) {
  const kernels::CellTransform t = transform_of(s, grid, k);
  kernels::best_kernels().place(points.padded_x_m().data(), points.padded_y_m().data(),
                                static_cast<int>(points.padded_x_m().size()), t.c, t.s, t.ox, t.oy,
                                t.limit, u, v);
}

MatchResult result_of(const CandidateSpace& s, const LikelihoodField& grid, const Best& best) {
  MatchResult r;
  const double mean = static_cast<double>(best.sum) / s.points;
  r.T_map_points = s.pose(best.candidate);
  r.mean_log_likelihood = grid.log_floor() + grid.log_step() * mean;
  r.score = mean / LikelihoodField::kMaxValue;
  r.candidate = best.candidate;
  r.candidates = s.count();
  return r;
}

SceneConstraint constraint_at(const LikelihoodField& grid, const PointSet& points,
                              const SE2d& T_map_points) {
  const auto near_a_wall = [&](const Eigen::Vector2d& p, const Eigen::Vector2d&) {
    return grid.value(cell_of(p, grid.resolution_m())) > LikelihoodField::kMaxValue / 2 ? 1.0 : 0.0;
  };
  return SceneConstraint::of(normals_outer(points, T_map_points, near_a_wall),
                             rms_distance_m(points));
}

}  // namespace detail

namespace {

using detail::Best;
using detail::CandidateSpace;

/// Calls `row(candidate at the row's start, count, sums)` for the rows of every heading.
template <class Row>
void sweep(const CandidateSpace& s, const LikelihoodField& grid, const PointSet& points,
           std::vector<std::int32_t>& u, std::vector<std::int32_t>& v,
           std::vector<std::int32_t>& index, Row&& row) {
  for (auto* scratch : {&u, &v, &index}) scratch->resize(points.padded_x_m().size());
  for (int k = -s.half_k; k <= s.half_k; ++k) {
    detail::place(s, grid, points, k, u.data(), v.data());
    detail::score_blocks(grid, s.points, u, v, index,
                         {{-s.half_x, -s.half_y}, {s.half_x, s.half_y}},
                         [&](const Cell& offset, int columns, const std::uint32_t* sums) {
                           row(Candidate{offset, k}, columns, sums);
                         });
  }
}

/// First and second moment of p ∝ exp(objective) over the window (Olson 2009, (12)), plus the
/// variance within a cell and a heading step.
Eigen::Matrix3d covariance_of(const CandidateSpace& s, const std::vector<std::uint32_t>& sums,
                              const Best& best) {
  constexpr double kNegligible = -40.0;
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  double total = 0;
  // The log prior is never positive: smaller sums are negligible.
  const double least = std::max(0.0, (best.objective + kNegligible) / s.weight - 1.0);
  const std::uint32_t* sum = sums.data();
  for (int k = -s.half_k; k <= s.half_k; ++k)
    for (int y = -s.half_y; y <= s.half_y; ++y)
      for (int x = -s.half_x; x <= s.half_x; ++x, ++sum) {
        if (static_cast<double>(*sum) < least) continue;
        const double log_p = s.objective(*sum, {{x, y}, k}) - best.objective;
        if (log_p < kNegligible) continue;
        const double p = std::exp(log_p);
        const Eigen::Vector3d d =
            s.delta({Cell{x, y} - best.candidate.offset, k - best.candidate.heading_step});
        second += p * d * d.transpose();
        first += p * d;
        total += p;
      }
  Eigen::Matrix3d covariance = second / total - first * first.transpose() / (total * total);
  const double cell = s.resolution_m * s.resolution_m / 12;
  covariance.diagonal() +=
      Eigen::Vector3d(cell, cell, std::max(1e-10, s.heading_step_rad * s.heading_step_rad / 12));
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  rotation.topLeftCorner<2, 2>() = s.pose(best.candidate).rotation().matrix().transpose();
  return rotation * covariance * rotation.transpose();
}

}  // namespace

Result<std::optional<MatchResult>> CorrelativeMatcher::match(const LikelihoodField& grid,
                                                             const PointSet& points,
                                                             const SE2d& prior,
                                                             const SearchWindow& window,
                                                             const MatchOptions& options) {
  const auto space = detail::plan(grid, points, prior, window, options,
                                  options.covariance ? kMaxSurface : kMaxCandidates);
  if (!space) return space.error();
  const CandidateSpace& s = *space;
  if (options.covariance) sums_.resize(static_cast<std::size_t>(s.count()));
  Best best;
  std::uint32_t least = static_cast<std::uint32_t>(s.min_sum);
  sweep(s, grid, points, u_, v_, index_, [&](Candidate c, int columns, const std::uint32_t* sums) {
    if (options.covariance) std::copy_n(sums, columns, sums_.data() + s.index(c));
    for (int i = 0; i < columns; ++i, ++c.offset.x) {
      // The log prior is never positive: a smaller sum cannot win.
      if (sums[i] < least) continue;
      best.offer(s.objective(sums[i], c), sums[i], c);
      least = std::max(least, static_cast<std::uint32_t>(detail::min_useful_sum(s, best)));
    }
  });
  if (!best.found) return std::optional<MatchResult>();
  MatchResult result = detail::result_of(s, grid, best);
  if (options.covariance) {
    result.covariance = covariance_of(s, sums_, best);
    result.constraint = detail::constraint_at(grid, points, result.T_map_points);
  }
  return std::optional<MatchResult>(result);
}

Result<ScoreSurface> CorrelativeMatcher::surface(const LikelihoodField& grid,
                                                 const PointSet& points, const SE2d& prior,
                                                 const SearchWindow& window,
                                                 const MatchOptions& options) {
  const auto space = detail::plan(grid, points, prior, window, options, kMaxSurface);
  if (!space) return space.error();
  const CandidateSpace& s = *space;
  ScoreSurface out{s.half_x, s.half_y, s.half_k, s.resolution_m, Angle::radians(s.heading_step_rad),
                   prior,    {}};
  out.log_score.resize(static_cast<std::size_t>(s.count()));
  const double floor = grid.log_floor() * s.points * (s.weight / grid.log_step());
  sweep(s, grid, points, u_, v_, index_, [&](Candidate c, int columns, const std::uint32_t* sums) {
    double* row = out.log_score.data() + s.index(c);
    for (int i = 0; i < columns; ++i, ++c.offset.x) row[i] = floor + s.objective(sums[i], c);
  });
  return out;
}

}  // namespace wayfare
