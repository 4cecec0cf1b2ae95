#pragma once

#include <chrono>
#include <cstdint>
#include <span>

#include <wayfare/decode/detail/line_time.hpp>
#include <wayfare/decode/rplidar_decoder.hpp>
#include <wayfare/decode/rplidar_points.hpp>
#include <wayfare/decode/rplidar_scan.hpp>

namespace wayfare::decode {

/// From an RPLIDAR's bytes, while they come, to whole turns with the times of their points.
class RplidarStream {
 public:
  explicit RplidarStream(int baud) : baud_(baud) {}

  /// Takes the next bytes, the last of which arrived at `arrived`; calls `sink(const RplidarTurn&)`
  /// with every whole turn they end.
  template <class Sink>
  void feed(Bytes bytes, LogTime arrived, Sink&& sink) {
    fed_ += bytes.size();
    decoder_.feed(bytes, [&](const RplidarPacket& packet) { take(packet, arrived, sink); });
  }

  [[nodiscard]] const DecoderStatistics& statistics() const { return decoder_.statistics(); }

 private:
  template <class Sink>
  void take(const RplidarPacket& packet, LogTime arrived, Sink& sink) {
    if (packet.answer() == RplidarAnswer::sample_rate && !packet.is_descriptor()) {
      rate_ = rplidar_sample_rate(packet.bytes()).value_or(rate_);
      return;
    }
    // A new request began in the middle of a turn.
    if (packet.is_descriptor()) turns_.finish([](const RplidarTurn&) {});
    const bool nodes = packet.answer() == RplidarAnswer::node;
    const Duration sample = std::chrono::microseconds(nodes ? rate_.standard_us : rate_.express_us);
    const std::uint64_t end = packet.position() + packet.bytes().size();
    const LogTime last =
        arrived - line_time(fed_ - end, baud_) - rplidar_delay(packet.answer(), sample, baud_);
    unpacker_.add(packet, [&](std::span<const RplidarPoint> points) {
      turns_.add(points, last, sample, [&](const RplidarTurn& turn) {
        if (turn.whole) sink(turn);
      });
    });
  }

  int baud_;
  RplidarDecoder decoder_;
  RplidarUnpacker unpacker_;
  RplidarTurns<> turns_;
  /// Samples of an A1 until the device says otherwise: 2000 nodes a second, 4000 in capsules.
  RplidarSampleRate rate_ = {500, 250};
  std::uint64_t fed_ = 0;
};

}  // namespace wayfare::decode
