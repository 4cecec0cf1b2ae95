#pragma once

// Simulated devices: recorded bytes in a pseudo-terminal, in real time or faster. And the scans in
// a radar's bytes.

#include <atomic>
#include <cstdint>
#include <vector>

#include <wayfare/core/detail/bytes.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/decode/ti_decoder.hpp>
#include <wayfare/decode/ti_frame.hpp>
#include <wayfare/logger/serial_port.hpp>
#include <wayfare/sync/clock_fit.hpp>

namespace wayfare::logger {

/// Bytes and their time since the beginning.
struct TimedBytes {
  Duration at{0};
  decode::Bytes bytes;
};

/// A capture without times as sent by a device of that rate, `piece` bytes at a time; both are
/// positive.
[[nodiscard]] std::vector<TimedBytes> at_rate(decode::Bytes bytes, double bytes_per_s,
                                              std::size_t piece = 256);

/// Writes all of it at `speed` > 0 times its rate, waiting for a slower reader. Returns the number
/// of bytes written: fewer if `stop` was set.
[[nodiscard]] Result<std::uint64_t> play(PseudoTerminal& terminal,
                                         const std::vector<TimedBytes>& stream, double speed,
                                         const std::atomic<bool>& stop);

/// Converts a TI radar's bytes, as they arrive, to scans in the computer's time.
class TiStream {
 public:
  /// `baud` > 0 of the line; `speed_step_mps` as of `decode::to_radar_scan`.
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
