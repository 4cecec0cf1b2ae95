#pragma once

#include <cstdint>

#include <wayfare/decode/detail/line_time.hpp>
#include <wayfare/decode/ti_decoder.hpp>
#include <wayfare/decode/ti_frame.hpp>
#include <wayfare/sync/clock_envelope.hpp>

namespace wayfare::logger {

/// Converts a TI radar's bytes, as they arrive, to scans in the computer's time.
class TiStream {
 public:
  /// `speed_step_mps` as of `decode::to_radar_scan`.
  explicit TiStream(int baud, double speed_step_mps = 0.0)
      : baud_(baud), speed_step_mps_(speed_step_mps) {}

  /// Takes the next bytes, the last of which arrived at `arrived`; calls `sink(const RadarScan&)`
  /// for every complete frame, with points or without.
  template <class Sink>
  void feed(decode::Bytes bytes, LogTime arrived, Sink&& sink) {
    fed_ += bytes.size();
    decoder_.feed(bytes, [&](const decode::TiFrame& frame) {
      const std::uint64_t end = frame.position() + frame.bytes().size();
      // The frame was sent when it was complete; bytes of the next may have arrived after its end.
      const LogTime sent = arrived - decode::line_time(fed_ - end + frame.bytes().size(), baud_);
      sink(decode::to_radar_scan(frame, envelope_.add(clock_.at(frame.header()), sent),
                                 speed_step_mps_));
    });
  }

  [[nodiscard]] const decode::DecoderStatistics& statistics() const {
    return decoder_.statistics();
  }

 private:
  int baud_;
  double speed_step_mps_;
  decode::TiDecoder decoder_;
  decode::TiClock clock_;
  ClockEnvelope envelope_;
  std::uint64_t fed_ = 0;
};

}  // namespace wayfare::logger
