#pragma once

// Revolutions from the bytes of an RPLIDAR as they arrive.

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>

#include <wayfare/core/detail/bytes.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/decode/rplidar_conf.hpp>
#include <wayfare/decode/rplidar_decoder.hpp>
#include <wayfare/decode/rplidar_protocol.hpp>
#include <wayfare/decode/rplidar_scan.hpp>

namespace wayfare::decode {

/// Decodes an RPLIDAR's byte stream into whole revolutions with the times of their points. The
/// stream may begin inside a scan.
class RplidarStream {
 public:
  /// `baud` > 0 of the line.
  explicit RplidarStream(int baud) : baud_(baud) {}

  /// Takes the next bytes, the last of which arrived at `arrived`; calls `sink(const
  /// RplidarRevolution&)` with every whole revolution they complete.
  template <class Sink>
  void feed(Bytes bytes, LogTime arrived, Sink&& sink) {
    fed_ += bytes.size();
    decoder_.feed(bytes, [&](const RplidarPacket& packet) { take(packet, arrived, sink); });
  }

  /// Of bytes and packets.
  [[nodiscard]] const DecoderStatistics& statistics() const { return decoder_.statistics(); }

 private:
  template <class Sink>
  void take(const RplidarPacket& packet, LogTime arrived, Sink& sink) {
    // A new request began in the middle of a revolution.
    if (packet.is_descriptor()) revolutions_.finish([](const RplidarRevolution&) {});
    if (!packet.is_descriptor() && !is_rplidar_scan(packet.response())) return take_reply(packet);
    const Duration sample =
        packet.response() == RplidarResponse::node ? node_sample_ : capsule_sample_;
    const std::uint64_t end = packet.position() + packet.bytes().size();
    const LogTime last =
        arrived - line_time(fed_ - end, baud_) - rplidar_delay(packet.response(), sample, baud_);
    unpacker_.add(packet, [&](std::span<const RplidarPoint> points) {
      revolutions_.add(points, last, sample, [&](const RplidarRevolution& revolution) {
        if (revolution.whole) sink(revolution);
      });
    });
  }

  /// The time of a sample: of both kinds of scans, or of the mode that is started next.
  void take_reply(const RplidarPacket& packet) {
    if (packet.response() == RplidarResponse::sample_rate) {
      const auto rate = rplidar_sample_rate(packet.bytes());
      if (!rate || rate->standard_us == 0 || rate->express_us == 0) return;
      node_sample_ = std::chrono::microseconds(rate->standard_us);
      capsule_sample_ = std::chrono::microseconds(rate->express_us);
    } else if (packet.response() == RplidarResponse::conf) {
      const auto conf = rplidar_conf(packet.bytes());
      const auto sample = conf ? rplidar_mode_sample(*conf) : std::nullopt;
      if (sample) node_sample_ = capsule_sample_ = *sample;
    }
  }

  int baud_;
  RplidarDecoder decoder_{RplidarFraming::running()};
  RplidarUnpacker unpacker_;
  RplidarRevolutions<> revolutions_;
  /// An A1's, until the device reports its own: 2000 nodes per second, 4000 in capsules.
  Duration node_sample_ = std::chrono::microseconds(500),
           capsule_sample_ = std::chrono::microseconds(250);
  std::uint64_t fed_ = 0;
};

}  // namespace wayfare::decode
