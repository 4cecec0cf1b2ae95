#pragma once

// Captures of devices as tables of text.

#include <charconv>
#include <concepts>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include <wayfare/core/detail/bytes.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/decode/mt_sample.hpp>
#include <wayfare/decode/rplidar_protocol.hpp>
#include <wayfare/decode/stream_decoder.hpp>

namespace wayfare::examples {

/// Comma-separated values. Numbers have the digits that restore them exactly.
class Csv {
 public:
  explicit Csv(std::string_view names) : text_(names) {}

  Csv& row() {
    text_ += '\n';
    first_ = true;
    return *this;
  }
  template <class T>
  requires std::integral<T> || std::floating_point<T> Csv& field(T value) {
    separate();
    char digits[32];
    const auto end = std::to_chars(digits, digits + sizeof digits, value).ptr;
    text_.append(digits, end);
    return *this;
  }
  Csv& field(std::string_view text) {
    separate();
    text_ += text;
    return *this;
  }
  Csv& empty(int fields = 1) {
    for (int i = 0; i < fields; ++i) separate();
    return *this;
  }
  /// The text, with a newline at the end.
  [[nodiscard]] std::string take() && {
    text_ += '\n';
    return std::move(text_);
  }

 private:
  void separate() {
    if (!first_) text_ += ',';
    first_ = false;
  }

  std::string text_;
  bool first_ = true;
};

/// A decoded capture.
struct Table {
  std::string csv;
  decode::DecoderStatistics statistics;
  std::string contents;  ///< "100 frames with 15857 points"
};

/// Passes the messages of a capture to `sink`. A decoder is too large for the stack.
template <class Decoder, class Sink, class... Framing>
decode::DecoderStatistics decode_all(decode::Bytes capture, const Sink& sink, Framing... framing) {
  const auto decoder = std::make_unique<Decoder>(framing...);
  decoder->feed(capture, sink);
  decoder->finish(sink);
  return decoder->statistics();
}

struct RplidarTableOptions {
  decode::RplidarResponse inside = decode::RplidarResponse::none;  ///< answer in which it begins
  double baud = 115200.0;
  double sample_us = 0.0;  ///< 0: as reported by the device, else 500 (nodes), 250 (capsules)
};

/// One line per point. `doppler_step_mps` is the speed of one Doppler bin, for frames before SDK 3.
[[nodiscard]] Table ti_table(decode::Bytes capture, std::optional<double> doppler_step_mps);
/// One line per point. Times are computed from the position in the capture and the line's rate.
[[nodiscard]] Table rplidar_table(decode::Bytes capture, const RplidarTableOptions& options);
/// One line per NAV-PVT, RXM-SFRBX, and measurement of RXM-RAWX; other messages are counted.
[[nodiscard]] Table ubx_table(decode::Bytes capture);
/// One line per GGA and RMC sentence; other sentences are counted.
[[nodiscard]] Table nmea_table(decode::Bytes capture);
/// One line per message; of an Awinda station, one line per tracker and frame.
[[nodiscard]] Table xsens_table(decode::Bytes capture, const decode::MtLegacyLayout& layout);

}  // namespace wayfare::examples
