#pragma once

// Revolutions from the bytes of an RPLIDAR as they arrive.

#include <chrono>
#include <cstdint>
#include <span>

#include <wayfare/core/detail/bytes.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/decode/rplidar_decoder.hpp>
#include <wayfare/decode/rplidar_protocol.hpp>
#include <wayfare/decode/rplidar_scan.hpp>

namespace wayfare::decode {

/// Decodes an RPLIDAR's byte stream into whole revolutions with the times of their points.
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
    if (packet.response() == RplidarResponse::sample_rate && !packet.is_descriptor()) {
      const auto rate = rplidar_sample_rate(packet.bytes());
      if (rate && rate->standard_us != 0 && rate->express_us != 0) rate_ = *rate;
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
