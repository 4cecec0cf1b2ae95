#pragma once

// Two tracks of one drive compared: time offset, rigid alignment, errors along and across and up.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/result.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/core/statistics.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/eval/table.hpp>
#include <wayfare/eval/track_curve.hpp>

namespace wayfare::eval {

/// How two tracks are compared.
struct TrackComparisonOptions {
  bool rigid = false;     ///< align the first with the second by a rigid motion
  double offset_s = 0.0;  ///< added to the times of the first
  /// The offset is searched within ± this around `offset_s`; 0: not. Searched is the least distance
  /// after rigid alignment, or without the mean difference.
  double search_s = 0.0;
  /// No interpolation of the second in gaps longer than this; 0: three times its usual interval, at
  /// least 1.5 s.
  double max_gap_s = 0.0;
};

/// The first track less the second at a time of the first.
struct TrackDifference {
  LogTime time;                 ///< on the clock of the second
  Eigen::Vector3d position_m;   ///< of the first, aligned
  Eigen::Vector3d reference_m;  ///< of the second, interpolated
  Eigen::Vector3d error_m;      ///< along, left, up
};

/// Two tracks compared.
struct TrackComparison {
  double offset_s = 0.0;                     ///< added to the times of the first
  SE3d alignment;                            ///< from the axes of the first to those of the second
  std::vector<TrackDifference> differences;  ///< in order of time
  double path_m = 0.0;                       ///< of the second, at the times compared
  std::vector<double> tried_s;               ///< offsets of the search
  std::vector<double> tried_rms_m;           ///< distances with them, without their mean or aligned
  /// Growth of the mean square of the distances with the square of the offset, (m/s)², from its
  /// value 50 ms to either side of the best; NaN without a search.
  double sharpness_mps2 = std::numeric_limits<double>::quiet_NaN();
  bool at_limit = false;  ///< the best offset is at the end of the search

  /// All errors of one axis (0 along, 1 left, 2 up).
  [[nodiscard]] std::vector<double> errors(Eigen::Index axis) const {
    std::vector<double> all;
    for (const TrackDifference& d : differences) all.push_back(d.error_m[axis]);
    return all;
  }
};

namespace detail {

struct TrackPairs {
  std::vector<std::size_t> index;
  std::vector<Eigen::Vector3d> from, to;
};

[[nodiscard]] inline TrackPairs track_pairs(std::span<const TrackPoint> a, const TrackCurve& b,
                                            double offset_s) {
  TrackPairs pairs;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const auto at = b.at(a[i].time + from_seconds(offset_s));
    if (!at) continue;
    pairs.index.push_back(i);
    pairs.from.push_back(a[i].position_m);
    pairs.to.push_back(*at);
  }
  return pairs;
}

[[nodiscard]] inline Eigen::Vector3d mean_step(std::span<const Eigen::Vector3d> from,
                                               std::span<const Eigen::Vector3d> to) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < from.size(); ++i) sum += to[i] - from[i];
  return sum / static_cast<double>(from.size());
}

/// Mean square of the distances with an offset, after rigid alignment or with the mean difference
/// removed: a constant difference, as of heights, would move the best offset along with any slope.
/// Infinite with fewer than `least` pairs.
[[nodiscard]] inline double mean_square(std::span<const TrackPoint> a, const TrackCurve& b,
                                        double offset_s, bool rigid, std::size_t least) {
  const TrackPairs pairs = track_pairs(a, b, offset_s);
  if (pairs.from.size() < std::max<std::size_t>(least, 2))
    return std::numeric_limits<double>::infinity();
  const SE3d T =
      rigid ? rigid_alignment(pairs.from, pairs.to) : SE3d(mean_step(pairs.from, pairs.to), SO3d());
  double sum = 0.0;
  for (std::size_t i = 0; i < pairs.from.size(); ++i)
    sum += (T * pairs.from[i] - pairs.to[i]).squaredNorm();
  return sum / static_cast<double>(pairs.from.size());
}

/// At most `count` points, evenly spread.
[[nodiscard]] inline Track thinned(const Track& track, std::size_t count) {
  const std::size_t step = std::max<std::size_t>(1, (track.size() + count - 1) / count);
  Track few;
  for (std::size_t i = 0; i < track.size(); i += step) few.push_back(track[i]);
  return few;
}

/// The offset of the least mean square: on a grid of 0.1 s (of a 400th of the search where that is
/// more), then by golden sections to 0.1 ms.
inline void search_offset(const Track& a, const TrackCurve& b, const TrackComparisonOptions& o,
                          TrackComparison& result) {
  const Track few = thinned(a, 1000), more = thinned(a, 5000);
  const double step = std::max(0.1, o.search_s / 200.0);
  const auto n = static_cast<int>(std::ceil(o.search_s / step));
  std::size_t most = 0;  // offsets with few common points must not win
  for (int i = -n; i <= n; ++i)
    most = std::max(most, track_pairs(few, b, o.offset_s + i * step).from.size());
  double best = std::numeric_limits<double>::infinity();
  int best_i = 0;
  for (int i = -n; i <= n; ++i) {
    const double offset = o.offset_s + i * step;
    const double value = mean_square(few, b, offset, o.rigid, most / 2);
    if (!std::isfinite(value)) continue;
    result.tried_s.push_back(offset);
    result.tried_rms_m.push_back(std::sqrt(value));
    if (value < best) best = value, best_i = i;
  }
  result.at_limit = std::abs(best_i) == n;
  const auto of = [&](double offset) { return mean_square(more, b, offset, o.rigid, 2); };
  const double kGolden = std::numbers::phi - 1.0;
  double low = o.offset_s + (best_i - 1) * step, high = low + 2.0 * step;
  double x0 = high - kGolden * (high - low), x1 = low + kGolden * (high - low);
  double f0 = of(x0), f1 = of(x1);
  while (high - low > 1e-4) {
    if (f0 < f1) {
      high = x1, x1 = x0, f1 = f0;
      f0 = of(x0 = high - kGolden * (high - low));
    } else {
      low = x0, x0 = x1, f0 = f1;
      f1 = of(x1 = low + kGolden * (high - low));
    }
  }
  result.offset_s = (low + high) / 2.0;
  constexpr double kAside_s = 0.05;
  const double aside = (of(result.offset_s - kAside_s) + of(result.offset_s + kAside_s)) / 2.0;
  result.sharpness_mps2 = (aside - of(result.offset_s)) / (kAside_s * kAside_s);
}

/// Horizontal directions of motion of the curve at times of it: over a second around each, held
/// where it moves by less than 0.3 m; the first known one before it.
[[nodiscard]] inline std::vector<Eigen::Vector2d> directions(
    const TrackCurve& curve, const std::vector<TrackDifference>& at) {
  constexpr Duration kHalf = std::chrono::milliseconds(500);
  constexpr double kLeast_m = 0.3;
  std::vector<Eigen::Vector2d> all(at.size(), Eigen::Vector2d::Zero());
  Eigen::Vector2d last = Eigen::Vector2d::Zero();
  std::size_t unknown = 0;
  for (std::size_t i = 0; i < at.size(); ++i) {
    const Eigen::Vector3d before = curve.at(at[i].time - kHalf).value_or(at[i].reference_m);
    const Eigen::Vector3d after = curve.at(at[i].time + kHalf).value_or(at[i].reference_m);
    const Eigen::Vector2d step = (after - before).head<2>();
    if (step.norm() >= kLeast_m) {
      if (last.isZero()) std::fill_n(all.begin(), unknown, step.normalized());
      last = step.normalized();
    }
    all[i] = last;
    unknown += last.isZero() ? 1 : 0;
  }
  if (last.isZero()) std::fill(all.begin(), all.end(), Eigen::Vector2d::UnitX());
  return all;
}

/// The error for tracks without common time, with the gap between them.
[[nodiscard]] inline Error no_overlap(const Track& a, const Track& b, double offset_s) {
  const double begin = a.front().time.seconds() + offset_s,
               end = a.back().time.seconds() + offset_s;
  const double gap = std::max(b.front().time.seconds() - end, begin - b.back().time.seconds());
  const double weeks = gap / 604800.0;
  std::string text = "the tracks do not overlap in time: the first is from " + fixed(begin, 3) +
                     " to " + fixed(end, 3) + " s, the second from " +
                     fixed(b.front().time.seconds(), 3) + " to " +
                     fixed(b.back().time.seconds(), 3) + " s";
  if (gap > 604800.0 / 2 && std::abs(weeks - std::round(weeks)) < 0.02)
    text += ": about " + fixed(std::round(weeks), 0) + " GPS weeks apart";
  else if (gap > 3e8)
    text += ": not the same clock";
  return {ErrorCode::not_found, text};
}

}  // namespace detail

/// Errors: a track that check() refuses (named as the first or second); options that are negative
/// or not finite; no time in common.
[[nodiscard]] inline Result<TrackComparison> compare_tracks(const Track& a, const Track& b,
                                                            const TrackComparisonOptions& o = {}) {
  for (const auto& [name, track] : {std::pair("the first track: ", &a), {"the second track: ", &b}})
    if (auto good = check(*track); !good)
      return Error{good.error().code, name + good.error().message};
  if (!std::isfinite(o.offset_s) || !(o.search_s >= 0.0 && o.search_s <= 1e5) ||
      !(o.max_gap_s >= 0.0 && o.max_gap_s <= 1e9))
    return Error{ErrorCode::invalid, "an option of the comparison is negative or not finite"};
  std::vector<Duration> intervals;
  for (std::size_t i = 1; i < b.size(); ++i) intervals.push_back(b[i].time - b[i - 1].time);
  const Duration usual = std::min(upper_median_of(intervals), Duration::max() / 3);
  const TrackCurve curve(b, o.max_gap_s > 0.0
                                ? from_seconds(o.max_gap_s)
                                : std::max<Duration>(std::chrono::milliseconds(1500), 3 * usual));
  TrackComparison result;
  result.offset_s = o.offset_s;
  if (o.search_s > 0.0) detail::search_offset(a, curve, o, result);
  const detail::TrackPairs pairs = detail::track_pairs(a, curve, result.offset_s);
  if (pairs.from.size() < 2) return detail::no_overlap(a, b, result.offset_s);
  if (o.rigid) result.alignment = rigid_alignment(pairs.from, pairs.to);
  for (std::size_t i = 0; i < pairs.from.size(); ++i)
    result.differences.push_back({a[pairs.index[i]].time + from_seconds(result.offset_s),
                                  result.alignment * pairs.from[i], pairs.to[i],
                                  Eigen::Vector3d::Zero()});
  const auto ahead = detail::directions(curve, result.differences);
  for (std::size_t i = 0; i < result.differences.size(); ++i) {
    TrackDifference& d = result.differences[i];
    const Eigen::Vector3d e = d.position_m - d.reference_m;
    d.error_m = {ahead[i].dot(e.head<2>()), ahead[i].x() * e.y() - ahead[i].y() * e.x(), e.z()};
    if (i > 0) result.path_m += (d.reference_m - result.differences[i - 1].reference_m).norm();
  }
  return result;
}

/// Signed mean, and RMS, median, 95 % and worst of the sizes, m: along, across, up, horizontal, in
/// space. Without heights the last two rows are of the plane.
[[nodiscard]] inline Table track_table(const TrackComparison& c, bool with_height = true) {
  Table table(
      {{"error"}, {"mean", "m"}, {"RMS", "m"}, {"median", "m"}, {"95 %", "m"}, {"worst", "m"}});
  const auto row = [&](const std::string& name, const auto& of) {
    std::vector<double> values, sizes;
    for (const TrackDifference& d : c.differences) {
      values.push_back(of(d.error_m));
      sizes.push_back(std::abs(values.back()));
    }
    const Summary s = summarise(sizes);
    table.add_row({name, fixed(summarise(values).mean, 3), fixed(s.rmse, 3), fixed(s.median, 3),
                   fixed(quantile(sizes, 0.95), 3), fixed(s.max, 3)});
  };
  row("along", [](const Eigen::Vector3d& e) { return e.x(); });
  row("across, to the left", [](const Eigen::Vector3d& e) { return e.y(); });
  if (with_height) row("up", [](const Eigen::Vector3d& e) { return e.z(); });
  row("horizontal", [](const Eigen::Vector3d& e) { return e.head<2>().norm(); });
  if (with_height) row("in space", [](const Eigen::Vector3d& e) { return e.norm(); });
  return table;
}

}  // namespace wayfare::eval
