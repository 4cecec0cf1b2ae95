#include "match/lines/wall_fit.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace wayfare::lines {
namespace {

/// Which points belong to a line: those within `at_foot_m` plus `per_m` for every metre along the
/// line from its foot.
struct Window {
  double at_foot_m = 0.0;
  double per_m = 0.0;
  /// Limits along each line, to exclude objects at its ends such as the next wall.
  std::array<double, 2> from_m{-1e300, -1e300}, to_m{1e300, 1e300};
};

/// Sums over the points of one line: t along it, d across from the guess, v the variance of d.
struct Sums {
  double n = 0, expected = 0, t = 0, d = 0, tt = 0, td = 0, dd = 0, v = 0, tv = 0, ttv = 0;
  double begin = 1e300, end = -1e300;

  void add(double along, double across, double variance) {
    n += 1, t += along, d += across;
    tt += along * along, td += along * across, dd += across * across;
    v += variance, tv += along * variance, ttv += along * along * variance;
    begin = std::min(begin, along), end = std::max(end, along);
  }
  /// About the mean: scatter, and Σ (t − t̄)² v, Σ (t − t̄) v.
  [[nodiscard]] double ctt() const { return tt - t * t / n; }
  [[nodiscard]] double ctd() const { return td - t * d / n; }
  [[nodiscard]] double cdd() const { return dd - d * d / n; }
  [[nodiscard]] double cttv() const { return ttv - 2.0 * t / n * tv + t * t / (n * n) * v; }
  [[nodiscard]] double ctv() const { return tv - t / n * v; }
};

std::array<Sums, 2> sums_near(const Beams& b, const Guess& g, const Window& window,
                              const WallOptions& options) {
  std::array<Sums, 2> sums;
  const double ux = std::cos(g.direction_rad), uy = std::sin(g.direction_rad);
  const double along2 = options.range_noise_m * options.range_noise_m;
  const double flat2 = options.flatness_m * options.flatness_m;
  for (std::size_t i = 0; i < b.range_m.size(); ++i) {
    const double q = ux * b.sin_bearing[i] - uy * b.cos_bearing[i];  // to the left
    const int side = q > 0.0 ? 0 : 1;
    const auto k = static_cast<std::size_t>(side);
    if (!g.present[k]) continue;
    Sums& s = sums[k];
    const double c = g.offset_m[k];
    s.expected += std::abs(c) < options.max_range_m * std::abs(q) ? 1.0 : 0.0;
    const double across = b.range_m[i] * q - c;
    const double along = b.range_m[i] * (ux * b.cos_bearing[i] + uy * b.sin_bearing[i]);
    const double near = window.at_foot_m + window.per_m * std::abs(along);
    if (!(std::abs(across) < near) || b.range_m[i] == 0.0) continue;
    if (along < window.from_m[k] || along > window.to_m[k]) continue;
    s.add(along, across, along2 * q * q + flat2);  // range noise is along the beam
  }
  return sums;
}

/// Covariance of the direction and of both offsets: δ = Σ (t − t̄) ε / S and c = ε̄ − t̄ δ.
Eigen::Matrix3d covariance_of(const std::array<Sums, 2>& sums, double scatter) {
  Eigen::Matrix3d cov = Eigen::Matrix3d::Zero();
  std::array<double, 2> mean_t{}, with_mean{};
  for (std::size_t k = 0; k < 2; ++k) {
    if (sums[k].n == 0) continue;
    cov(0, 0) += sums[k].cttv() / (scatter * scatter);
    mean_t[k] = sums[k].t / sums[k].n;
    with_mean[k] = sums[k].ctv() / (sums[k].n * scatter);
  }
  for (std::size_t k = 0; k < 2; ++k) {
    if (sums[k].n == 0) continue;
    const auto row = static_cast<Eigen::Index>(k + 1);
    cov(0, row) = cov(row, 0) = with_mean[k] - mean_t[k] * cov(0, 0);
    cov(row, row) = sums[k].v / (sums[k].n * sums[k].n) + mean_t[k] * mean_t[k] * cov(0, 0) -
                    2.0 * mean_t[k] * with_mean[k];
  }
  if (sums[0].n > 0 && sums[1].n > 0)
    cov(1, 2) = cov(2, 1) =
        mean_t[0] * mean_t[1] * cov(0, 0) - mean_t[0] * with_mean[1] - mean_t[1] * with_mean[0];
  return cov;
}

void describe(Fit& fit, const std::array<Sums, 2>& sums) {
  for (std::size_t k = 0; k < 2; ++k) {
    fit.beams[k] = static_cast<int>(sums[k].n);
    fit.expected[k] = static_cast<int>(sums[k].expected);
    if (!fit.lines.present[k]) continue;
    fit.begin_m[k] = sums[k].begin;
    fit.end_m[k] = sums[k].end;
    fit.spread_m2[k] = sums[k].ctt();
    fit.slope_rad[k] = fit.lines.direction_rad + sums[k].ctd() / sums[k].ctt();
    fit.slope_sigma_rad[k] = std::sqrt(sums[k].cttv()) / sums[k].ctt();
  }
}

/// One iteration on the points within the window of the guess: one direction for both lines and an
/// offset for each. A line with fewer than `min_beams` is dropped.
Fit fit_once(const Beams& beams, const Guess& guess, const Window& window,
             const WallOptions& options) {
  std::array<Sums, 2> sums = sums_near(beams, guess, window, options);
  Fit fit;
  fit.lines = guess;
  double tt = 0.0, td = 0.0, dd = 0.0, n = 0.0, v = 0.0;
  for (std::size_t k = 0; k < 2; ++k) {
    const bool kept = guess.present[k] && sums[k].n >= options.min_beams &&
                      sums[k].n >= options.min_beam_fraction * sums[k].expected &&
                      sums[k].ctt() > 1e-4;
    fit.lines.present[k] = kept;
    if (!kept) {
      sums[k] = Sums{.expected = sums[k].expected};
      continue;
    }
    tt += sums[k].ctt(), td += sums[k].ctd(), dd += sums[k].cdd(), n += sums[k].n, v += sums[k].v;
  }
  if (!(tt > 0.0)) return fit;
  describe(fit, sums);
  const double turn = 0.5 * std::atan2(2.0 * td, tt - dd);
  fit.lines.direction_rad = guess.direction_rad + turn;
  for (std::size_t k = 0; k < 2; ++k) {
    if (!fit.lines.present[k]) continue;
    fit.lines.offset_m[k] = (guess.offset_m[k] + sums[k].d / sums[k].n) * std::cos(turn) -
                            sums[k].t / sums[k].n * std::sin(turn);
  }
  const double residual = std::max(dd - 2.0 * turn * td + turn * turn * tt, 0.0);
  // A wall rougher than the options assume has larger residuals.
  fit.covariance =
      covariance_of(sums, tt) * std::max(1.0, residual / std::max(n - 3.0, 1.0) * n / v);
  return fit;
}

constexpr double kCell_m = 0.01;
constexpr std::size_t kCells = 128;  // the first and last are empty
constexpr double kMiddle = 64.0;     // half of them

/// A point near a guessed line; its offset is evaluated to first order in a rotation of the line.
struct NearPoint {
  float along_m, across_m;
  std::int16_t length;  ///< of wall per beam, in quarters
  std::int16_t side;
};

/// Histogram of the length of wall by offset from the guess, and its maxima over three cells.
struct OffsetHistogram {
  // 16 bits, so that one instruction compares eight cells; fits 200 points of at most 100.
  std::array<std::array<std::int16_t, kCells>, 2> length{};
  std::array<std::size_t, 2> best{};

  /// Sum of the maxima of both sides.
  int accumulate(std::span<const NearPoint> points, double turn_rad) {
    length = {};
    const auto turn = static_cast<float>(turn_rad);
    for (const NearPoint& p : points) {
      const float across = p.across_m - turn * p.along_m;
      const float cell = across * static_cast<float>(1.0 / kCell_m) + static_cast<float>(kMiddle);
      if (cell < 1.0F || cell >= static_cast<float>(kCells - 1)) continue;
      auto& here = length[static_cast<std::size_t>(p.side)][static_cast<std::size_t>(cell)];
      here = static_cast<std::int16_t>(here + p.length);
    }
    return most(0) + most(1);
  }
  /// Sum of three cells.
  [[nodiscard]] std::int16_t at(std::size_t k, std::size_t c) const {
    return static_cast<std::int16_t>(length[k][c - 1] + length[k][c] + length[k][c + 1]);
  }
  [[nodiscard]] std::int16_t most(std::size_t k) const {
    std::int16_t found = 0;
    for (std::size_t c = 1; c + 1 < kCells; ++c) found = std::max(found, at(k, c));
    return found;
  }
  void find_best() {
    for (std::size_t k = 0; k < 2; ++k) {
      const std::int16_t wanted = most(k);
      best[k] = 1;
      while (at(k, best[k]) != wanted) ++best[k];
    }
  }
  /// Doors are recessed in a wall: of two parallel surfaces the nearer one is the wall, even if
  /// less of it is visible.
  void prefer_nearer() {
    constexpr double kShare = 0.35;
    constexpr std::size_t kLeast = 4, kMost = 10;  // cells
    for (std::size_t k = 0; k < 2; ++k) {
      const std::size_t from = best[k];
      double longest = kShare * at(k, from);
      for (std::size_t d = kLeast; d <= kMost; ++d) {
        const std::size_t c =
            k == 0 ? from - std::min(d, from - 1) : std::min(from + d, kCells - 2);
        if (at(k, c) <= longest) continue;
        longest = at(k, c);
        best[k] = c;
      }
    }
  }
  [[nodiscard]] double offset_m(std::size_t k) const {
    return (static_cast<double>(best[k]) + 0.5 - kMiddle) * kCell_m;
  }
};

constexpr std::size_t kMaxBeams = 200;  // a finer scan is subsampled

std::span<const NearPoint> points_near(const Beams& b, const Guess& guess, double max_shift_m,
                                       std::array<NearPoint, kMaxBeams>& points) {
  constexpr double kNear_m = 6.0;
  const double half = std::min(max_shift_m, (kMiddle - 8.0) * kCell_m);
  const double ux = std::cos(guess.direction_rad), uy = std::sin(guess.direction_rad);
  const std::size_t step = 1 + b.range_m.size() / kMaxBeams;
  std::size_t n = 0;
  for (std::size_t i = 0; i < b.range_m.size(); i += step) {
    const double q = ux * b.sin_bearing[i] - uy * b.cos_bearing[i];
    const std::size_t k = q > 0.0 ? 0 : 1;
    const double across = b.range_m[i] * q - guess.offset_m[k];
    const double along = b.range_m[i] * (ux * b.cos_bearing[i] + uy * b.sin_bearing[i]);
    if (!guess.present[k] || !(std::abs(across) < half) || std::abs(along) > kNear_m ||
        b.range_m[i] == 0.0)
      continue;
    points[n++] = {static_cast<float>(along), static_cast<float>(across),
                   static_cast<std::int16_t>(4.0 * std::min(b.range_m[i] / std::abs(q), 25.0)),
                   static_cast<std::int16_t>(k)};
  }
  return std::span(points).first(n);
}

}  // namespace

Guess align(const Beams& beams, const Guess& guess, double max_shift_m, double max_turn_rad) {
  constexpr double kCoarse_rad = 0.01, kFine_rad = 0.004;
  std::array<NearPoint, kMaxBeams> storage;
  const std::span<const NearPoint> points = points_near(beams, guess, max_shift_m, storage);
  OffsetHistogram histogram;
  int most = histogram.accumulate(points, 0.0);
  double turn = 0.0;
  const auto try_turn = [&](double tried) {
    const int length = histogram.accumulate(points, tried);
    if (length <= most) return;
    most = length;
    turn = tried;
  };
  for (int i = 1; i * kCoarse_rad <= max_turn_rad; ++i)
    for (const double side : {-1.0, 1.0}) try_turn(side * i * kCoarse_rad);
  const double coarse = turn;
  for (const double side : {-1.0, 1.0}) try_turn(coarse + side * kFine_rad);
  Guess aligned = guess;
  if (histogram.accumulate(points, turn) <= 0) return aligned;
  histogram.find_best();
  histogram.prefer_nearer();
  aligned.direction_rad += turn;
  for (std::size_t k = 0; k < 2; ++k)
    if (guess.present[k]) aligned.offset_m[k] += histogram.offset_m(k);
  return aligned;
}

Fit fit_walls(const Beams& beams, const Guess& guess, const WallOptions& options) {
  const double noise = std::hypot(options.range_noise_m, options.flatness_m);
  const double last = std::max(4.0 * noise, 0.02);
  const Fit fit = fit_once(beams, guess, {1.25 * last, 0.003}, options);
  // An adjoining wall has points near the line, all on one side and at its end, where they bias the
  // direction most.
  Window ends{last, 0.0};
  for (std::size_t k = 0; k < 2; ++k) {
    ends.from_m[k] = fit.begin_m[k] + 2.0 * last;
    ends.to_m[k] = fit.end_m[k] - 2.0 * last;
  }
  return fit_once(beams, fit.lines, ends, options);
}

}  // namespace wayfare::lines
