#pragma once

// Whole turns of an RPLIDAR, and the library's scan made of one.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <span>

#include <wayfare/core/time.hpp>
#include <wayfare/decode/rplidar_points.hpp>
#include <wayfare/sensors/laser_scan.hpp>

namespace wayfare::decode {

/// A point with the time it was measured at.
struct TimedRplidarPoint {
  RplidarPoint point;
  LogTime time;
};

/// One turn, as long as it is shown. The first after a start, and one with more points than there
/// was room for, is not whole.
struct RplidarTurn {
  std::span<const TimedRplidarPoint> points;
  bool whole = false;
};

/// How long before the last byte of a packet arrived its last point was measured: half a sample,
/// the time on the line (ten bits a byte), and, of capsules, whose points come with the next one,
/// the samples of that.
[[nodiscard]] inline Duration rplidar_delay(RplidarAnswer answer, Duration sample, double baud) {
  const bool node = answer == RplidarAnswer::node, ultra = answer == RplidarAnswer::ultra;
  const int points = ultra ? 96 : answer == RplidarAnswer::dense ? 40 : 32;
  const double bits = 10.0 * (node ? 5 : ultra ? 132 : 84);
  return sample / 2 + from_seconds(bits / baud) + (node ? Duration(0) : sample * points);
}

/// Gathers points into turns of at most `kMaxPoints`.
template <std::size_t kMaxPoints = 8192>
class RplidarTurns {
 public:
  /// Points in the order they were measured, the last at `last`, `sample` apart. Calls
  /// `sink(const RplidarTurn&)` for a turn that the next one's first point ends.
  template <class Sink>
  void add(std::span<const RplidarPoint> points, LogTime last, Duration sample, Sink&& sink) {
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (points[i].start_of_turn) end_turn(sink);
      const auto to_last = static_cast<std::int64_t>(points.size() - 1 - i);
      if (size_ == kMaxPoints) {
        ++dropped_;
        whole_ = false;
      } else {
        points_[size_++] = {points[i], last - sample * to_last};
      }
    }
  }

  /// The turn under way, whole or not, and no more.
  template <class Sink>
  void finish(Sink&& sink) {
    whole_ = false;
    end_turn(sink);
    whole_ = false;
  }

  [[nodiscard]] std::uint64_t dropped_points() const { return dropped_; }

 private:
  template <class Sink>
  void end_turn(Sink& sink) {
    if (size_ != 0) sink(RplidarTurn{std::span(points_).first(size_), whole_});
    size_ = 0;
    whole_ = true;
  }

  std::array<TimedRplidarPoint, kMaxPoints> points_{};
  std::size_t size_ = 0;
  bool whole_ = false;
  std::uint64_t dropped_ = 0;
};

struct RplidarScanOptions {
  std::size_t beams = 360;    ///< of the scan, evenly around
  float min_range_m = 0.15F;  ///< nearer is no return
  float max_range_m = 12.0F;  ///< farther is no return
};

/// The turn as a scan of even bearings, −π first, counter-clockwise: each beam has the nearest
/// point of its part of the turn, NaN where there is none. Its time is that of the turn's first
/// point.
[[nodiscard]] inline LaserScan to_laser_scan(const RplidarTurn& turn,
                                             const RplidarScanOptions& options = {}) {
  const double step = 2.0 * std::numbers::pi / static_cast<double>(options.beams);
  LaserScan scan{turn.points.empty() ? LogTime{} : turn.points.front().time,
                 Angle::radians(-std::numbers::pi),
                 Angle::radians(step),
                 options.min_range_m,
                 options.max_range_m,
                 {}};
  scan.ranges_m.assign(options.beams, std::numeric_limits<float>::quiet_NaN());
  for (const TimedRplidarPoint& p : turn.points) {
    const auto range = static_cast<float>(p.point.distance_m());
    if (!(range >= options.min_range_m && range < options.max_range_m)) continue;
    const double from_back = (180.0 - p.point.angle_deg()) / 360.0;  // clockwise to counter-
    const double beam =
        std::round((from_back < 0.0 ? from_back + 1.0 : from_back) * double(options.beams));
    float& kept = scan.ranges_m[static_cast<std::size_t>(beam) % options.beams];
    if (!(kept <= range)) kept = range;
  }
  return scan;
}

}  // namespace wayfare::decode
