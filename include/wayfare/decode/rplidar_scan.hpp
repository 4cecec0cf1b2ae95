#pragma once

// Full revolutions of an RPLIDAR, and their conversion to a LaserScan.

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <span>

#include <wayfare/core/time.hpp>
#include <wayfare/decode/detail/line_time.hpp>
#include <wayfare/decode/rplidar_decoder.hpp>
#include <wayfare/decode/rplidar_points.hpp>
#include <wayfare/decode/rplidar_protocol.hpp>
#include <wayfare/sensors/laser_scan.hpp>

namespace wayfare::decode {

/// A point with the time it was measured at.
struct TimedRplidarPoint {
  RplidarPoint point;
  LogTime time;
};

/// One revolution, valid only during the call of the sink. The first after a start, and one with
/// more points than fit, is not whole.
struct RplidarRevolution {
  std::span<const TimedRplidarPoint> points;
  bool whole = false;
};

/// Time from the measurement of a packet's last point to the arrival of its last byte: half a
/// sample, the time on the line (ten bits per byte), and for capsules, whose points are decoded
/// with the next one, the samples of that.
[[nodiscard]] inline Duration rplidar_delay(RplidarResponse response, Duration sample,
                                            double baud) {
  const bool node = response == RplidarResponse::node, ultra = response == RplidarResponse::ultra;
  const int points = ultra ? 96 : response == RplidarResponse::dense ? 40 : 32;
  const double bits = 10.0 * (node ? 5 : ultra ? 132 : 84);
  return sample / 2 + from_seconds(bits / baud) + (node ? Duration(0) : sample * points);
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
      if (points[i].start_of_revolution) end_revolution(sink);
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

  [[nodiscard]] std::uint64_t dropped_points() const { return dropped_; }

 private:
  template <class Sink>
  void end_revolution(Sink& sink) {
    if (size_ != 0) sink(RplidarRevolution{std::span(points_).first(size_), whole_});
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
  float min_range_m = 0.15F;  ///< nearer points are dropped
  float max_range_m = 12.0F;  ///< farther points are dropped
};

/// Converts a revolution to a scan with evenly spaced bearings from −π, counter-clockwise: each
/// beam has the nearest point of its sector, or NaN. The scan's time is that of the first point.
[[nodiscard]] inline LaserScan to_laser_scan(const RplidarRevolution& revolution,
                                             const RplidarScanOptions& options = {}) {
  const double step = 2.0 * std::numbers::pi / static_cast<double>(options.beams);
  LaserScan scan{revolution.points.empty() ? LogTime{} : revolution.points.front().time,
                 Angle::radians(-std::numbers::pi),
                 Angle::radians(step),
                 options.min_range_m,
                 options.max_range_m,
                 {}};
  scan.ranges_m.assign(options.beams, std::numeric_limits<float>::quiet_NaN());
  for (const TimedRplidarPoint& p : revolution.points) {
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

/// Decodes an RPLIDAR's byte stream into whole revolutions with the times of their points.
class RplidarStream {
 public:
  explicit RplidarStream(int baud) : baud_(baud) {}

  /// Takes the next bytes, the last of which arrived at `arrived`; calls `sink(const
  /// RplidarRevolution&)` with every whole revolution they complete.
  template <class Sink>
  void feed(Bytes bytes, LogTime arrived, Sink&& sink) {
    fed_ += bytes.size();
    decoder_.feed(bytes, [&](const RplidarPacket& packet) { take(packet, arrived, sink); });
  }

  [[nodiscard]] const DecoderStatistics& statistics() const { return decoder_.statistics(); }

 private:
  template <class Sink>
  void take(const RplidarPacket& packet, LogTime arrived, Sink& sink) {
    if (packet.response() == RplidarResponse::sample_rate && !packet.is_descriptor()) {
      rate_ = rplidar_sample_rate(packet.bytes()).value_or(rate_);
      return;
    }
    // A new request began in the middle of a revolution.
    if (packet.is_descriptor()) revolutions_.finish([](const RplidarRevolution&) {});
    const bool nodes = packet.response() == RplidarResponse::node;
    const Duration sample = std::chrono::microseconds(nodes ? rate_.standard_us : rate_.express_us);
    const std::uint64_t end = packet.position() + packet.bytes().size();
    const LogTime last =
        arrived - line_time(fed_ - end, baud_) - rplidar_delay(packet.response(), sample, baud_);
    unpacker_.add(packet, [&](std::span<const RplidarPoint> points) {
      revolutions_.add(points, last, sample, [&](const RplidarRevolution& revolution) {
        if (revolution.whole) sink(revolution);
      });
    });
  }

  int baud_;
  RplidarDecoder decoder_;
  RplidarUnpacker unpacker_;
  RplidarRevolutions<> revolutions_;
  /// An A1's, until the device reports its own: 2000 nodes per second, 4000 in capsules.
  RplidarSampleRate rate_ = {500, 250};
  std::uint64_t fed_ = 0;
};

}  // namespace wayfare::decode
