#include <wayfare/match/lines.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

#include "match/lines/candidates.hpp"

namespace wayfare {
namespace {

using lines::Fit;
using lines::Guess;

constexpr double kQuarter = 0.5 * std::numbers::pi;

/// Largest error of segment directions: a segment may connect a wall with a recessed door.
constexpr double kSegmentDirectionError_rad = 0.05;

/// Two walls with a larger correlation are accepted without trying other candidates.
constexpr double kClearCorrelation = 0.45;

Eigen::Vector2d left_of(Angle direction) {
  return {-std::sin(direction.radians()), std::cos(direction.radians())};
}

std::optional<Wall> wall_of(const Fit& fit, std::size_t k) {
  if (!fit.lines.present[k]) return {};
  return Wall{fit.lines.offset_m[k], fit.beams[k], fit.begin_m[k], fit.end_m[k]};
}

/// A line at this direction and offset as a normal point; (direction, offset), of which row 0 and
/// `row` of `covariance` are, reordered to (ρ, α).
NormalPoint normal_point(double direction_rad, double offset_m, const Eigen::Matrix3d& covariance,
                         int row) {
  const double side = offset_m < 0.0 ? -1.0 : 1.0;
  NormalPoint p{side * offset_m, Angle::radians(direction_rad + side * kQuarter).wrapped()};
  p.covariance << covariance(row, row), side * covariance(0, row), side * covariance(0, row),
      covariance(0, 0);
  return p;
}

/// Length of the walls times the fraction of expected beams that hit them.
double support(const CorridorWalls& walls) {
  double length = 0.0;
  for (const auto* wall : {&walls.left, &walls.right})
    if (*wall) length += (*wall)->end_m - (*wall)->begin_m;
  return walls.correlation * length;
}

/// Whether line `i` of one fit has the slope of line `j` of another.
bool same_slope(const Fit& a, std::size_t i, const Fit& b, std::size_t j) {
  return std::abs(a.slope_rad[i] - b.slope_rad[j]) <
         4.0 * std::hypot(a.slope_sigma_rad[i], b.slope_sigma_rad[j]) + 0.01;
}

Guess only(std::size_t k, Guess lines) {
  lines.present[1 - k] = false;
  return lines;
}

CorridorWalls to_walls(const Fit& fit, bool parallel, std::optional<Angle> near) {
  CorridorWalls walls;
  walls.direction = Angle::radians(fit.lines.direction_rad);
  walls.left = wall_of(fit, 0);
  walls.right = wall_of(fit, 1);
  walls.covariance = fit.covariance;
  walls.parallel = parallel;
  double hits = 0.0, expected = 0.0;
  for (std::size_t k = 0; k < 2; ++k) {
    if (!fit.lines.present[k]) continue;
    hits += fit.beams[k];
    expected += fit.expected[k];
  }
  walls.correlation = expected > 0.0 ? std::min(hits / expected, 1.0) : 0.0;
  const double about = near ? near->radians() : 0.0;
  const double away = std::remainder(fit.lines.direction_rad - about, 2.0 * std::numbers::pi);
  return away > kQuarter || away <= -kQuarter ? reversed(walls) : walls;
}

/// Fits of lines near guesses.
struct Fitter {
  const lines::Beams& beams;
  const WallOptions& options;

  [[nodiscard]] Fit fit_near(const Guess& guess, double max_shift_m, double max_turn_rad) const {
    return lines::fit_walls(beams, lines::align(beams, guess, max_shift_m, max_turn_rad), options);
  }

  /// Of the two directions, the one within 90° of `near` or of ahead.
  [[nodiscard]] std::optional<CorridorWalls> corridor(const Guess& guess, double max_shift_m,
                                                      double max_turn_rad,
                                                      std::optional<Angle> near) const {
    Fit fit = fit_near(guess, max_shift_m, max_turn_rad);
    const bool parallel = are_parallel(fit) && !is_oblique(guess, fit);
    if (!parallel && fit.lines.present[0] && fit.lines.present[1]) {
      const std::size_t longer = fit.spread_m2[0] < fit.spread_m2[1] ? 1 : 0;
      fit = lines::fit_walls(beams, only(longer, fit.lines), options);
    }
    if (!fit.lines.present[0] && !fit.lines.present[1]) return {};
    return to_walls(fit, parallel, near);
  }

  /// Whether an expected wall is missing from the fit because it is not parallel to the other.
  [[nodiscard]] bool is_oblique(const Guess& guess, const Fit& fit) const {
    constexpr double kReach_m = 0.1, kTurn_rad = 0.06;
    for (const std::size_t k : {std::size_t{0}, std::size_t{1}}) {
      if (!guess.present[k] || fit.lines.present[k] || !fit.lines.present[1 - k]) continue;
      Guess alone = only(k, guess);
      alone.direction_rad = fit.lines.direction_rad;
      const Fit own = fit_near(alone, kReach_m, kTurn_rad);
      if (own.lines.present[k] && !same_slope(own, k, fit, 1 - k)) return true;
    }
    return false;
  }

  /// Compares the slopes of both walls in the joint fit. A wall hit by only some of its beams may
  /// be a line that crosses the window, so it is also fitted alone.
  [[nodiscard]] bool are_parallel(const Fit& fit) const {
    if (!fit.lines.present[0] || !fit.lines.present[1]) return true;
    if (!same_slope(fit, 0, fit, 1)) return false;
    const auto visible_length = [&](std::size_t k) {
      return (fit.end_m[k] - fit.begin_m[k]) * fit.beams[k] / std::max(1.0 * fit.expected[k], 1.0);
    };
    const std::size_t weaker = visible_length(0) < visible_length(1) ? 0 : 1;
    if (visible_length(weaker) > 0.5 * visible_length(1 - weaker)) return true;
    const Fit own = lines::fit_walls(beams, only(weaker, fit.lines), options);
    return !own.lines.present[weaker] || same_slope(own, weaker, fit, 1 - weaker);
  }

  /// A wall across the corridor is accepted if it is visible over half a metre.
  [[nodiscard]] std::optional<NormalPoint> end(const Guess& across, double max_shift_m,
                                               double max_turn_rad) const {
    constexpr double kLeastLength_m = 0.5;
    WallOptions hidden = options;  // the corridor's walls occlude most of a line across it
    hidden.min_beam_fraction = 0.0;
    const Fit fit = Fitter{beams, hidden}.fit_near(across, max_shift_m, max_turn_rad);
    if (!fit.lines.present[0] || fit.end_m[0] - fit.begin_m[0] < kLeastLength_m) return {};
    if (!(fit.lines.offset_m[0] > 0.0)) return {};
    return normal_point(fit.lines.direction_rad, fit.lines.offset_m[0], fit.covariance, 1);
  }

  /// The walls of the best candidate.
  [[nodiscard]] std::optional<CorridorWalls> best_of(
      const std::vector<lines::Candidate>& candidates, std::span<const lines::Segment> segments,
      std::optional<Angle> near) const {
    std::optional<CorridorWalls> walls;
    for (const lines::Candidate& candidate : candidates) {
      const auto next =
          corridor(candidate.lines, options.capture_m, kSegmentDirectionError_rad, near);
      if (next && (!walls || support(*next) > support(*walls))) walls = next;
      if (walls && walls->left && walls->right && walls->correlation > kClearCorrelation) break;
    }
    if (!walls || !options.end_walls) return walls;
    if (const auto across = lines::wall_across(segments, walls->direction.radians()))
      walls->end = end(*across, 0.05, 0.004);
    return walls;
  }
};

/// Three standard deviations of a prediction, or the options' values if it has no covariance.
struct SearchRange {
  double offset_m, max_turn_rad;
};

SearchRange window_of(const CorridorWalls& predicted, double tracking_m) {
  const Eigen::Vector3d sigma = predicted.covariance.diagonal().cwiseSqrt();
  const double offset =
      3.0 * std::max(predicted.left ? sigma[1] : 0.0, predicted.right ? sigma[2] : 0.0);
  return {std::clamp(offset > 0.0 ? offset : tracking_m, 0.01, std::max(tracking_m, 0.01)),
          std::clamp(sigma[0] > 0.0 ? 3.0 * sigma[0] : 0.02, 0.001, 0.05)};
}

}  // namespace

NormalPoint CorridorWalls::left_point() const {
  return normal_point(direction.radians(), left->offset_m, covariance, 1);
}

NormalPoint CorridorWalls::right_point() const {
  return normal_point(direction.radians(), right->offset_m, covariance, 2);
}

CorridorWalls moved(const CorridorWalls& walls, const SE2d& motion) {
  CorridorWalls next = walls;
  const Eigen::Vector2d n = left_of(walls.direction);
  const Eigen::Vector2d u(n.y(), -n.x());
  next.direction = walls.direction - motion.heading();
  for (auto* wall : {&next.left, &next.right}) {
    if (!*wall) continue;
    (*wall)->offset_m -= n.dot(motion.translation());
    (*wall)->begin_m -= u.dot(motion.translation());
    (*wall)->end_m -= u.dot(motion.translation());
  }
  if (next.end) {
    const double a = next.end->alpha.radians();
    next.end->rho_m -= Eigen::Vector2d(std::cos(a), std::sin(a)).dot(motion.translation());
    next.end->alpha = (next.end->alpha - motion.heading()).wrapped();
  }
  return next;
}

CorridorWalls reversed(const CorridorWalls& walls) {
  CorridorWalls next = walls;
  next.direction = Angle::radians(walls.direction.radians() + std::numbers::pi).wrapped();
  std::swap(next.left, next.right);
  for (auto* wall : {&next.left, &next.right}) {
    if (!*wall) continue;
    (*wall)->offset_m = -(*wall)->offset_m;
    const double begin = (*wall)->begin_m;
    (*wall)->begin_m = -(*wall)->end_m;
    (*wall)->end_m = -begin;
  }
  Eigen::Matrix3d exchange;
  exchange << 1, 0, 0, 0, 0, -1, 0, -1, 0;
  next.covariance = exchange * walls.covariance * exchange.transpose();
  return next;
}

std::optional<CorridorWalls> WallDetector::acquire(const LaserScan& scan,
                                                   std::optional<Angle> near) {
  beams_.load(scan, options_.max_range_m);
  const auto segments = lines::split(beams_, options_);
  return Fitter{beams_, options_}.best_of(lines::agreed_walls(segments, near, options_), segments,
                                          near);
}

std::optional<CorridorWalls> WallDetector::search(const LaserScan& scan,
                                                  std::optional<Angle> near) {
  beams_.load(scan, options_.max_range_m);
  const auto segments = lines::split(beams_, options_);
  return Fitter{beams_, options_}.best_of(lines::correlated_walls(beams_, near, options_), segments,
                                          near);
}

std::optional<CorridorWalls> WallDetector::fit_windows(const LaserScan& scan,
                                                       std::optional<Angle> near) {
  beams_.load(scan, options_.max_range_m);
  return lines::windowed_walls(beams_, near, options_);
}

std::optional<SquareDirection> WallDetector::square_direction(const LaserScan& scan, Angle near,
                                                              Angle within) {
  beams_.load(scan, options_.max_range_m);
  return lines::square_direction(lines::split(beams_, options_), near, within,
                                 options_.min_support_m);
}

std::optional<CorridorWalls> WallDetector::track(const LaserScan& scan,
                                                 const CorridorWalls& predicted) {
  beams_.load(scan, options_.max_range_m);
  const Fitter fitter{beams_, options_};
  Guess guess;
  guess.direction_rad = predicted.direction.radians();
  guess.present = {predicted.left.has_value(), predicted.right.has_value()};
  if (predicted.left) guess.offset_m[0] = predicted.left->offset_m;
  if (predicted.right) guess.offset_m[1] = predicted.right->offset_m;
  const SearchRange range = window_of(predicted, options_.tracking_m);
  auto walls = fitter.corridor(guess, range.offset_m, range.max_turn_rad, predicted.direction);
  if (!walls || walls->correlation < options_.min_correlation) return {};
  if (options_.end_walls && predicted.end && predicted.end->rho_m > 0.0) {
    const Guess across{
        predicted.end->alpha.radians() - kQuarter, {predicted.end->rho_m, 0.0}, {true, false}};
    walls->end = fitter.end(across, options_.tracking_m, range.max_turn_rad);
  }
  return walls;
}

}  // namespace wayfare
