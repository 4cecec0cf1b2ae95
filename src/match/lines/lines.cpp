#include <wayfare/match/lines.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>
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

/// A fit's first line as a normal point; (direction, offset) reordered to (ρ, α).
NormalPoint point_of(const Fit& fit) {
  NormalPoint p{fit.lines.offset_m[0], Angle::radians(fit.lines.direction_rad + kQuarter).wrapped(),
                Eigen::Matrix2d::Zero()};
  p.covariance << fit.covariance(1, 1), fit.covariance(0, 1), fit.covariance(0, 1),
      fit.covariance(0, 0);
  return p;
}

/// Length of the walls times the fraction of expected beams that hit them.
double support(const CorridorWalls& walls) {
  double length = 0.0;
  for (const auto* wall : {&walls.left, &walls.right})
    if (*wall) length += (*wall)->end_m - (*wall)->begin_m;
  return walls.correlation * length;
}

bool same_slope(double a_rad, double a_sigma, double b_rad, double b_sigma) {
  return std::abs(a_rad - b_rad) < 4.0 * std::hypot(a_sigma, b_sigma) + 0.01;
}

}  // namespace

NormalPoint CorridorWalls::normal_point(int row, const Wall& wall) const {
  const double side = wall.offset_m < 0.0 ? -1.0 : 1.0;
  NormalPoint p{side * wall.offset_m,
                Angle::radians(direction.radians() + side * kQuarter).wrapped(),
                Eigen::Matrix2d::Zero()};
  p.covariance << covariance(row, row), side * covariance(0, row), side * covariance(0, row),
      covariance(0, 0);
  return p;
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

class WallDetector::Engine {
 public:
  explicit Engine(const WallOptions& options) : options_(options) {}

  std::optional<CorridorWalls> acquire(const LaserScan& scan, std::optional<Angle> near,
                                       bool by_search) {
    beams_.load(scan, options_.max_range_m);
    if (beams_.x_m.empty()) return {};
    splitter_.split(beams_, options_, segments_);
    const auto found = by_search ? lines::correlated_walls(beams_, near, options_)
                                 : lines::agreed_walls(segments_, near, options_);
    std::optional<CorridorWalls> walls;
    for (const lines::Candidate& candidate : found) {
      const auto next =
          fit_corridor(candidate.lines, options_.capture_m, kSegmentDirectionError_rad, near);
      if (next && (!walls || support(*next) > support(*walls))) walls = next;
      if (walls && walls->left && walls->right && walls->correlation > kClearCorrelation) break;
    }
    if (!walls || !options_.end_walls) return walls;
    if (const auto across = lines::wall_across(segments_, walls->direction.radians()))
      walls->end = fit_end(*across, 0.05, 0.004);
    return walls;
  }

  std::optional<CorridorWalls> track(const LaserScan& scan, const CorridorWalls& predicted) {
    beams_.load(scan, options_.max_range_m);
    Guess guess;
    guess.direction_rad = predicted.direction.radians();
    guess.present = {predicted.left.has_value(), predicted.right.has_value()};
    if (predicted.left) guess.offset_m[0] = predicted.left->offset_m;
    if (predicted.right) guess.offset_m[1] = predicted.right->offset_m;
    const SearchRange range = window_of(predicted);
    auto walls = fit_corridor(guess, range.offset_m, range.max_turn_rad, predicted.direction);
    if (!walls || walls->correlation < options_.min_correlation) return {};
    if (options_.end_walls && predicted.end && predicted.end->rho_m > 0.0) {
      Guess across;
      across.direction_rad = predicted.end->alpha.radians() - kQuarter;
      across.offset_m[0] = predicted.end->rho_m;
      across.present[0] = true;
      walls->end = fit_end(across, options_.tracking_m, range.max_turn_rad);
    }
    return walls;
  }

 private:
  /// Three standard deviations of a prediction, or the options' values if it has no covariance.
  struct SearchRange {
    double offset_m, max_turn_rad;
  };
  [[nodiscard]] SearchRange window_of(const CorridorWalls& predicted) const {
    const Eigen::Vector3d sigma = predicted.covariance.diagonal().cwiseSqrt();
    const double offset =
        3.0 * std::max(predicted.left ? sigma[1] : 0.0, predicted.right ? sigma[2] : 0.0);
    return {std::clamp(offset > 0.0 ? offset : options_.tracking_m, 0.01, options_.tracking_m),
            std::clamp(sigma[0] > 0.0 ? 3.0 * sigma[0] : 0.02, 0.001, 0.05)};
  }

  /// Of the two directions, the one within 90° of `near` or of ahead.
  std::optional<CorridorWalls> fit_corridor(const Guess& guess, double max_shift_m,
                                            double max_turn_rad, std::optional<Angle> near) {
    Fit fit = lines::fit_walls(beams_, aligner_.align(beams_, guess, max_shift_m, max_turn_rad),
                               options_);
    const bool parallel = are_parallel(fit) && !is_oblique(guess, fit);
    if (!parallel && fit.lines.present[0] && fit.lines.present[1]) {
      Guess longer = fit.lines;
      longer.present[fit.spread_m2[0] < fit.spread_m2[1] ? 0 : 1] = false;
      fit = lines::fit_walls(beams_, longer, options_);
    }
    if (!fit.lines.present[0] && !fit.lines.present[1]) return {};
    return to_walls(fit, parallel, near);
  }

  /// Whether an expected wall is missing from the fit because it is not parallel to the other.
  [[nodiscard]] bool is_oblique(const Guess& guess, const Fit& fit) {
    constexpr double kReach_m = 0.1, kTurn_rad = 0.06;
    for (const std::size_t k : {std::size_t{0}, std::size_t{1}}) {
      if (!guess.present[k] || fit.lines.present[k] || !fit.lines.present[1 - k]) continue;
      Guess alone = guess;
      alone.present[1 - k] = false;
      alone.direction_rad = fit.lines.direction_rad;
      const Fit own =
          lines::fit_walls(beams_, aligner_.align(beams_, alone, kReach_m, kTurn_rad), options_);
      if (own.lines.present[k] && !same_slope(own.slope_rad[k], own.slope_sigma_rad[k],
                                              fit.slope_rad[1 - k], fit.slope_sigma_rad[1 - k]))
        return true;
    }
    return false;
  }

  /// Compares the slopes of both walls in the joint fit. A wall hit by only some of its beams may
  /// be a line that crosses the window, so it is also fitted alone.
  [[nodiscard]] bool are_parallel(const Fit& fit) const {
    if (!fit.lines.present[0] || !fit.lines.present[1]) return true;
    if (!same_slope(fit.slope_rad[0], fit.slope_sigma_rad[0], fit.slope_rad[1],
                    fit.slope_sigma_rad[1]))
      return false;
    const auto visible_length = [&](std::size_t k) {
      return (fit.end_m[k] - fit.begin_m[k]) * fit.beams[k] / std::max(1.0 * fit.expected[k], 1.0);
    };
    const std::size_t weaker = visible_length(0) < visible_length(1) ? 0 : 1;
    if (visible_length(weaker) > 0.5 * visible_length(1 - weaker)) return true;
    Guess alone = fit.lines;
    alone.present[1 - weaker] = false;
    const Fit own = lines::fit_walls(beams_, alone, options_);
    if (!own.lines.present[weaker]) return true;
    return same_slope(own.slope_rad[weaker], own.slope_sigma_rad[weaker], fit.slope_rad[1 - weaker],
                      fit.slope_sigma_rad[1 - weaker]);
  }

  static CorridorWalls to_walls(const Fit& fit, bool parallel, std::optional<Angle> near) {
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
    if (away > kQuarter || away <= -kQuarter) return reversed(walls);
    return walls;
  }

  /// A wall across the corridor is accepted if it is visible over half a metre.
  std::optional<NormalPoint> fit_end(const Guess& across, double max_shift_m, double max_turn_rad) {
    constexpr double kLeastLength_m = 0.5;
    WallOptions hidden = options_;  // the corridor's walls occlude most of a line across it
    hidden.min_beam_fraction = 0.0;
    const Fit fit =
        lines::fit_walls(beams_, aligner_.align(beams_, across, max_shift_m, max_turn_rad), hidden);
    if (!fit.lines.present[0] || fit.end_m[0] - fit.begin_m[0] < kLeastLength_m) return {};
    if (!(fit.lines.offset_m[0] > 0.0)) return {};
    return point_of(fit);
  }

  WallOptions options_;
  lines::Beams beams_;
  lines::Splitter splitter_;
  lines::GuessAligner aligner_;
  std::vector<lines::Segment> segments_;
};

WallDetector::WallDetector(const WallOptions& options)
    : engine_(std::make_unique<Engine>(options)) {}
WallDetector::~WallDetector() = default;
WallDetector::WallDetector(WallDetector&&) noexcept = default;
WallDetector& WallDetector::operator=(WallDetector&&) noexcept = default;

std::optional<CorridorWalls> WallDetector::acquire(const LaserScan& scan,
                                                   std::optional<Angle> near) {
  return engine_->acquire(scan, near, false);
}

std::optional<CorridorWalls> WallDetector::search(const LaserScan& scan,
                                                  std::optional<Angle> near) {
  return engine_->acquire(scan, near, true);
}

std::optional<CorridorWalls> WallDetector::track(const LaserScan& scan,
                                                 const CorridorWalls& predicted) {
  return engine_->track(scan, predicted);
}

}  // namespace wayfare
