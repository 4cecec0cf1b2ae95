#pragma once

// Captures of devices as tables of text.

#include <charconv>
#include <concepts>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <wayfare/core/detail/bytes.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/core/time.hpp>
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
  std::string contents;      ///< "100 frames with 15857 points"
  std::string refused = {};  ///< why the last bytes that begin like a frame are none
};

/// Passes the messages of a capture to `sink`. A decoder is too large for the stack.
template <class Decoder, class Sink, class... Framing>
decode::DecoderStatistics decode_all(decode::Bytes capture, const Sink& sink, Framing... framing) {
  const auto decoder = std::make_unique<Decoder>(framing...);
  decoder->feed(capture, sink);
  decoder->finish(sink);
  return decoder->statistics();
}

/// The bytes of a device, and when they were read, where they are from a recording.
struct Capture {
  struct Arrival {
    std::uint64_t end = 0;  ///< bytes up to here had arrived
    LogTime time;
  };
  std::string bytes;
  std::vector<Arrival> arrivals;

  [[nodiscard]] decode::Bytes view() const {
    return {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()};
  }
  /// When byte `end - 1` had arrived, by the recording or else by a line of `baud`.
  [[nodiscard]] LogTime arrival(std::uint64_t end, double baud) const;
};

/// A capture, plain or gzip, or what a device sent in a logger's recording (.mcap): the channel of
/// bytes named `topic`, or the only one of a device of `kind`. `damage` describes faults of the
/// file.
[[nodiscard]] Result<Capture> read_capture(const std::string& path, const std::string& topic,
                                           const std::string& kind, std::string& damage);

struct RplidarTableOptions {
  decode::RplidarResponse inside = decode::RplidarResponse::none;  ///< answer in which it begins
  double baud = 115200.0;
  double sample_us = 0.0;  ///< 0: as reported by the device, else 500 (nodes), 250 (capsules)
};

/// One line per point. `doppler_step_mps` is the speed of one Doppler bin, for frames before SDK 3.
[[nodiscard]] Table ti_table(decode::Bytes capture, std::optional<double> doppler_step_mps);
/// One line per point. Times are computed from the position in the capture and the line's rate, or
/// from a recording's times of arrival.
[[nodiscard]] Table rplidar_table(const Capture& capture, const RplidarTableOptions& options);
/// Tables of what a TI radar sends besides points.
enum class TiTable {
  points,       ///< as ti_table
  frames,       ///< one line per frame, also of empty ones: statistics, temperatures
  profiles,     ///< one line per range bin
  doppler_map,  ///< one line per range and Doppler bin
  azimuth_map,  ///< one line per range bin and antenna
  targets,      ///< one line per tracked target
};
[[nodiscard]] Table ti_other_table(decode::Bytes capture, TiTable table);
/// Tables of what an Xsens unit sends besides samples.
enum class XsensTable {
  samples,     ///< as xsens_table
  gnss,        ///< one line per solution of its receiver
  satellites,  ///< one line per satellite of a message
  raw,         ///< one line per message with uncalibrated readings
};
[[nodiscard]] Table xsens_other_table(decode::Bytes capture, XsensTable table);
/// One line per NAV-PVT, RXM-SFRBX, and measurement of RXM-RAWX; other messages are counted.
[[nodiscard]] Table ubx_table(decode::Bytes capture);
/// One line per GGA and RMC sentence; other sentences are counted.
[[nodiscard]] Table nmea_table(decode::Bytes capture);
/// One line per message; of an Awinda station, one line per tracker and frame.
[[nodiscard]] Table xsens_table(decode::Bytes capture, const decode::MtLegacyLayout& layout);

}  // namespace wayfare::examples
