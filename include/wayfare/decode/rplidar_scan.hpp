#pragma once

// Points from an RPLIDAR's nodes and capsules, with the arithmetic of the maker's own unpacker
// (Slamtec/rplidar_sdk, dataunpacker), so that they agree bit for bit; full revolutions, and their
// conversion to a LaserScan.

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <span>

#include <wayfare/core/detail/bytes.hpp>
#include <wayfare/core/detail/eigen_alignment.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/decode/detail/rplidar_capsules.hpp>
#include <wayfare/decode/rplidar_decoder.hpp>
#include <wayfare/decode/rplidar_point.hpp>
#include <wayfare/decode/rplidar_protocol.hpp>
#include <wayfare/sensors/scans.hpp>

namespace wayfare::decode {

/// Converts packets to points. A capsule's points, except an HQ capsule's, need the start angle of
/// the next one: they are delivered with it, and dropped where bytes were lost between the two.
class RplidarUnpacker {
 public:
  /// Calls `sink(std::span<const RplidarPoint>)` where the packet completes points, at most 96.
  template <class Sink>
  void add(const RplidarPacket& packet, Sink&& sink) {
    const Bytes b = packet.bytes();
    if (packet.is_descriptor()) return reset();
    if (packet.response() == RplidarResponse::node) {
      if (b.size() != 5) return;
      points_[0] = rplidar_node(b);
      return sink(std::span<const RplidarPoint>(points_.data(), 1));
    }
    if (b.empty() || b.size() != rplidar_packet_bytes(packet.response())) return;
    if (packet.response() == RplidarResponse::hq) return add_hq(b, sink);
    // The first after a start or a reset of the encoder.
    const bool first = (b[start_at(packet.response()) + 1] & 0x80) != 0;
    if (!first && length_ == b.size() && packet.position() == end_ &&
        packet.response() == response_)
      sink(std::span<const RplidarPoint>(points_.data(), unpack(b)));
    std::copy(b.begin(), b.end(), capsule_.begin());
    length_ = b.size();
    end_ = packet.position() + b.size();
    response_ = packet.response();
  }

  /// Before another stream.
  void reset() {
    length_ = 0;
    ultra_dense_ = {};
  }

 private:
  /// Byte of a capsule at which its start angle is.
  static constexpr std::size_t start_at(RplidarResponse response) {
    return response == RplidarResponse::ultra_dense ? 8 : 2;
  }
  static int start_q6(const std::uint8_t* capsule, std::size_t at = 2) {
    return (load_le<std::uint16_t>(capsule + at) & 0x7FFF) % (360 * 64);
  }

  template <class Sink>
  void add_hq(Bytes b, Sink& sink) {
    length_ = 0;
    std::array<RplidarPoint, 96> points;
    for (std::size_t i = 0; i < points.size(); ++i) detail::hq_point(&b[9 + 8 * i], points[i]);
    sink(std::span<const RplidarPoint>(points));
  }

  std::size_t unpack(Bytes next) {
    if (response_ == RplidarResponse::express) return unpack_express(next);
    if (response_ == RplidarResponse::dense) return unpack_dense(next);
    if (response_ == RplidarResponse::ultra) return unpack_ultra(next);
    ultra_dense_.unpack(capsule_.data(), start_q6(capsule_.data(), 8), start_q6(next.data(), 8),
                        points_.data());
    return 64;
  }

  std::size_t unpack_express(Bytes next) {
    detail::CapsuleAngles angles(start_q6(capsule_.data()), start_q6(next.data()), 32);
    for (std::size_t cabin = 0; cabin < 16; ++cabin) {
      const std::uint8_t* p = &capsule_[4 + 5 * cabin];
      const int d1 = load_le<std::uint16_t>(p), d2 = load_le<std::uint16_t>(p + 2);
      const int offset1_q3 = (d1 & 3) << 4 | (p[4] & 0xF), offset2_q3 = (d2 & 3) << 4 | p[4] >> 4;
      angles.next(points_[2 * cabin], static_cast<std::uint32_t>(d1 & ~3), offset1_q3 << 13);
      angles.next(points_[2 * cabin + 1], static_cast<std::uint32_t>(d2 & ~3), offset2_q3 << 13);
    }
    return 32;
  }

  [[gnu::noinline]] std::size_t unpack_dense(Bytes next) {
    detail::CapsuleAngles angles(start_q6(capsule_.data()), start_q6(next.data()), 40);
    for (std::size_t i = 0; i < 40; ++i)
      angles.next(points_[i], std::uint32_t{load_le<std::uint16_t>(&capsule_[4 + 2 * i])} << 2, 0);
    return 40;
  }

  std::size_t unpack_ultra(Bytes next) {
    detail::CapsuleAngles angles(start_q6(capsule_.data()), start_q6(next.data()), 96);
    for (std::size_t cabin = 0; cabin < 32; ++cabin) {
      const auto word = load_le<std::uint32_t>(&capsule_[4 + 4 * cabin]);
      const auto after = load_le<std::uint32_t>(cabin < 31 ? &capsule_[8 + 4 * cabin] : &next[4]);
      const detail::VariableScale scale1(static_cast<int>(word & 0xFFFU));
      const detail::VariableScale scale2(static_cast<int>(after & 0xFFFU));
      const auto& base1 = scale1.value == 0 && scale2.value != 0 ? scale2 : scale1;
      const std::array<std::uint32_t, 3> distances = {
          static_cast<std::uint32_t>(scale1.value) << 2,
          predicted(static_cast<std::int32_t>(word << 10) >> 22, base1),
          predicted(static_cast<std::int32_t>(word) >> 22, scale2)};
      for (std::size_t i = 0; i < 3; ++i)
        angles.next(points_[3 * cabin + i], distances[i], detail::ultra_offset_q16(distances[i]));
    }
    return 96;
  }

  /// A distance coded as the difference from another; the ends of the scale mean no return.
  static std::uint32_t predicted(std::int32_t difference, const detail::VariableScale& base) {
    if (difference == -512 || difference == 511) return 0;
    const int value = difference * (1 << base.level) + base.value;
    return value > 0 ? static_cast<std::uint32_t>(value) << 2 : 0;
  }

  std::array<std::uint8_t, 170> capsule_{};  ///< the previous one
  std::size_t length_ = 0;                   ///< its length, 0 for none
  std::uint64_t end_ = 0;
  RplidarResponse response_ = RplidarResponse::none;
  std::array<RplidarPoint, 96> points_{};
  detail::UltraDensePoints ultra_dense_;
};

/// A point with the time it was measured at.
struct TimedRplidarPoint {
  RplidarPoint point;  ///< as measured
  LogTime time;        ///< of the measurement
};

/// One revolution, valid only during the call of the sink. The first after a start, one with more
/// points than fit, and one of more than a turn and a half, where a start was lost, is not whole.
struct RplidarRevolution {
  std::span<const TimedRplidarPoint> points;  ///< in order of time
  bool whole = false;                         ///< from its first point to its last
};

/// Time from the measurement of a packet's last point to the arrival of its last byte: half a
/// sample, the time on the line (ten bits per byte), and for capsules whose points are decoded
/// with the next one, the samples of that.
[[nodiscard]] inline Duration rplidar_delay(RplidarResponse response, Duration sample,
                                            double baud) {
  const bool at_once = response == RplidarResponse::node || response == RplidarResponse::hq;
  const double bits = 10.0 * static_cast<double>(rplidar_packet_bytes(response));
  return sample / 2 + from_seconds(bits / baud) +
         (at_once ? Duration(0) : sample * rplidar_packet_points(response));
}

/// Whether a point begins a revolution: it has the mark of a start, and is within 45° of ahead.
/// Elsewhere the mark is one of damage, such as a request's echo inside a node.
[[nodiscard]] inline bool rplidar_begins_revolution(const RplidarPoint& point) {
  constexpr int kTurn_q6 = 360 * 64, kAhead_q6 = 45 * 64;
  return point.start_of_revolution &&
         (point.angle_q6 <= kAhead_q6 || point.angle_q6 >= kTurn_q6 - kAhead_q6);
}

/// Gathers points into revolutions of at most `kMaxPoints`.
template <std::size_t kMaxPoints = 8192>
class RplidarRevolutions {
 public:
  /// Points in order of measurement, the last at `last`, `sample` apart. Calls `sink(const
  /// RplidarRevolution&)` for a revolution when the first point of the next one arrives.
  template <class Sink>
  void add(std::span<const RplidarPoint> points, LogTime last, Duration sample, Sink&& sink) {
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (rplidar_begins_revolution(points[i])) end_revolution(sink);
      const auto to_last = static_cast<std::int64_t>(points.size() - 1 - i);
      if (size_ == kMaxPoints) {
        ++dropped_;
        whole_ = false;
      } else {
        points_[size_++] = {points[i], last - sample * to_last};
      }
    }
  }

  /// Delivers the current, incomplete revolution.
  template <class Sink>
  void finish(Sink&& sink) {
    whole_ = false;
    end_revolution(sink);
    whole_ = false;
  }

  [[nodiscard]] std::uint64_t dropped_points() const { return dropped_; }  ///< beyond kMaxPoints

 private:
  static constexpr int kTurn_q6 = 360 * 64;

  /// From one point to the next, by the shorter way.
  static int advance_q6(const RplidarPoint& from, const RplidarPoint& to) {
    const int step_q6 = int{to.angle_q6} - int{from.angle_q6};
    if (step_q6 > kTurn_q6 / 2) return step_q6 - kTurn_q6;
    return step_q6 < -kTurn_q6 / 2 ? step_q6 + kTurn_q6 : step_q6;
  }

  /// Less than a turn and a half from the first point to the last, by sixteen steps between them.
  [[nodiscard]] bool is_one() const {
    constexpr std::size_t kSteps = 16;
    int travel_q6 = 0;
    for (std::size_t i = 0; i < kSteps; ++i)
      travel_q6 += advance_q6(points_[i * (size_ - 1) / kSteps].point,
                              points_[(i + 1) * (size_ - 1) / kSteps].point);
    return travel_q6 < kTurn_q6 + kTurn_q6 / 2;
  }

  template <class Sink>
  void end_revolution(Sink& sink) {
    if (size_ != 0) sink(RplidarRevolution{std::span(points_).first(size_), whole_ && is_one()});
    size_ = 0;
    whole_ = true;
  }

  std::array<TimedRplidarPoint, kMaxPoints> points_{};
  std::size_t size_ = 0;
  bool whole_ = false;
  std::uint64_t dropped_ = 0;
};

/// Beams and ranges of to_laser_scan.
struct RplidarScanOptions {
  std::size_t beams = 360;    ///< of the scan, evenly around
  float min_range_m = 0.15F;  ///< nearer points are dropped; those without return always
  float max_range_m = 12.0F;  ///< farther points are dropped
};

/// Converts a revolution to a scan with evenly spaced bearings from −π, counter-clockwise: each
/// beam has the nearest point of its sector, or NaN. The scan's time is that of the first point.
/// Without beams it is empty.
[[nodiscard]] inline LaserScan to_laser_scan(const RplidarRevolution& revolution,
                                             const RplidarScanOptions& options = {}) {
  const double step =
      options.beams == 0 ? 0.0 : 2.0 * std::numbers::pi / static_cast<double>(options.beams);
  LaserScan scan{revolution.points.empty() ? LogTime{} : revolution.points.front().time,
                 Angle::radians(-std::numbers::pi),
                 Angle::radians(step),
                 options.min_range_m,
                 options.max_range_m,
                 {}};
  scan.ranges_m.assign(options.beams, std::numeric_limits<float>::quiet_NaN());
  if (options.beams == 0) return scan;
  for (const TimedRplidarPoint& p : revolution.points) {
    const auto range = static_cast<float>(p.point.distance_m());
    if (p.point.distance_q2 == 0) continue;
    if (!(range >= options.min_range_m && range < options.max_range_m)) continue;
    const double from_back = (180.0 - p.point.angle_deg()) / 360.0;  // clockwise to counter-
    const double turn = from_back - std::floor(from_back);
    const double beam = std::round(turn * static_cast<double>(options.beams));
    float& kept = scan.ranges_m[static_cast<std::size_t>(beam) % options.beams];
    if (!(kept <= range)) kept = range;
  }
  return scan;
}

}  // namespace wayfare::decode
