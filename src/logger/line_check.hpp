#pragma once

// Finds that the bytes of a line become no measurements, and the likely cause.

#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include <wayfare/logger/device_decoder.hpp>

namespace wayfare::logger {

/// Why a decoder of `device` makes no measurements of these bytes: they are another device's, or
/// text, or of another baud rate.
[[nodiscard]] std::string likely_cause(decode::Bytes bytes, const DeviceDescription& device);

/// Watches a decoder: a warning begins where for `patience` more than half of the bytes are in no
/// message, or none of the messages is a measurement, and ends where that is not so for a sixth of
/// it.
class LineCheck {
 public:
  /// `so_far`: the decoder's results of the bytes before.
  LineCheck(DeviceDescription device, Duration patience, const DecodingStatus& so_far = {})
      : device_(std::move(device)),
        patience_(patience),
        now_{0, so_far.skipped_bytes, so_far.messages},
        window_(now_),
        good_(now_) {}

  /// The bytes just read, and what the decoder made of all.
  void add(decode::Bytes bytes, const DecodingStatus& decoding, LogTime now);
  /// With the number of bytes; empty: none.
  [[nodiscard]] std::string warning() const;

 private:
  struct Counts {
    std::uint64_t bytes = 0, skipped = 0, messages = 0;
  };
  void judge(const Counts& window, const Counts& counts, LogTime now);

  DeviceDescription device_;
  Duration patience_;
  std::string recent_;  ///< bytes
  Counts now_, window_,
      good_;  ///< at the last read, the beginning of the window, the last good one
  std::optional<LogTime> window_begin_, bad_since_, found_;
  std::string cause_;
};

}  // namespace wayfare::logger
