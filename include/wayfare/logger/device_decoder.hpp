#pragma once

// Decoding of a device's bytes to time-stamped messages, as they arrive; and simulated devices:
// recorded bytes in a pseudo-terminal, in real time or faster.

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <wayfare/core/detail/bytes.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/decode/awinda.hpp>
#include <wayfare/decode/mt_sample.hpp>
#include <wayfare/decode/ti_decoder.hpp>
#include <wayfare/decode/ti_frame.hpp>
#include <wayfare/decode/xbus.hpp>
#include <wayfare/logger/device_messages.hpp>
#include <wayfare/logger/serial_port.hpp>
#include <wayfare/sensors/measurements.hpp>
#include <wayfare/sync/clock_fit.hpp>

namespace wayfare::logger {

/// Bytes and their time since the beginning.
struct TimedBytes {
  Duration at{0};       ///< since the beginning of the stream
  decode::Bytes bytes;  ///< sent then
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
    feed_frames(bytes, arrived, [&](const decode::TiFrame& frame, LogTime time) {
      sink(decode::to_radar_scan(frame, time, speed_step_mps_));
    });
  }

  /// The same, but calls `sink(const decode::TiFrame&, LogTime)`; the frame is valid until it
  /// returns.
  template <class Sink>
  void feed_frames(decode::Bytes bytes, LogTime arrived, Sink&& sink) {
    fed_ += bytes.size();
    decoder_.feed(bytes, [&](const decode::TiFrame& frame) {
      const std::uint64_t end = frame.position() + frame.bytes().size();
      // The frame was sent when it was complete; bytes of the next may have arrived after its end.
      const LogTime sent = arrived - decode::line_time(fed_ - end + frame.bytes().size(), baud_);
      const bool clock = frame.header().has_clock();
      sink(frame, clock ? envelope_.add(clock_.at(frame.header()), sent) : sent);
    });
  }

  /// As of `decode::to_radar_scan`.
  [[nodiscard]] double speed_step_mps() const { return speed_step_mps_; }
  /// The last bytes that are no frame though they begin like one.
  [[nodiscard]] const decode::TiRefusal& refusal() const { return decoder_.framing().refusal(); }
  /// Counts of frames and of bytes that belong to none.
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

/// Converts the bytes of an Xsens MTi, or of an Awinda station with its MTw trackers, as they
/// arrive, to samples in the computer's time.
class XsensStream {
 public:
  /// The tracker's identifier, nothing for an MTi; the field in units of 49 µT over the field at
  /// the place of calibration.
  using Sink = std::function<void(std::optional<std::uint32_t> tracker, const MargSample& sample)>;
  /// The same with what a message has besides, whenever there is something.
  using StateSink = std::function<void(std::optional<std::uint32_t> tracker, const MtState& state)>;

  /// `baud` > 0 of the line.
  explicit XsensStream(int baud) : baud_(baud) {}

  /// Takes the next bytes, the last of which arrived at `arrived`.
  void feed(decode::Bytes bytes, LogTime arrived, const Sink& sink, const StateSink& states = {});

  /// Counts of bytes and frames.
  [[nodiscard]] const decode::DecoderStatistics& statistics() const {
    return decoder_.statistics();
  }

 private:
  void take(const decode::XbusMessage& message, LogTime sent, const Sink& sink,
            const StateSink& states);
  void take(const decode::AwindaSnapshot& snapshot, LogTime sent, const Sink& sink,
            const StateSink& states);
  LogTime take(const decode::MtSample& sample, LogTime sent, const Sink& sink);
  void begin(double period_s);

  int baud_;
  decode::XbusDecoder decoder_;
  std::unique_ptr<decode::AwindaStation<>> station_;  ///< limits the number of trackers
  double period_s_ = 0.01;
  decode::CounterUnwrapper frames_{std::uint64_t{1} << 32};
  decode::CounterUnwrapper fine_{std::uint64_t{1} << 32};
  ClockEnvelope envelope_;
  std::uint64_t fed_ = 0;
};

/// A stream of messages of one type, as described in a recording. The topic identifies it.
struct Stream {
  std::string topic;                                 ///< name of the channel, such as /radar/points
  std::string encoding = "json";                     ///< of the messages
  std::string schema = {};                           ///< name; empty: none
  std::string schema_json = {};                      ///< its definition
  std::map<std::string, std::string> metadata = {};  ///< pairs of the channel's description
};

/// A measurement as a message.
struct DecodedMessage {
  std::shared_ptr<const Stream> stream;  ///< the channel it belongs to
  LogTime time;                          ///< of the measurement
  std::string json;                      ///< by the stream's schema
};

/// Results of decoding so far.
struct DecodingStatus {
  std::uint64_t messages = 0;       ///< frames, revolutions or samples decoded
  std::uint64_t skipped_bytes = 0;  ///< that belong to no message
  std::uint64_t damaged = 0;        ///< frames with a wrong checksum or wrong lengths
  /// Summary of the last message; before the first, why what arrived is none, if that is known.
  std::string sample = {};
  /// The last measurement as JSON, a few hundred bytes: of a unit `t` (s), `force` and `rate`; of a
  /// laser scan `t`, `from_deg`, `step_deg` and the ranges `cm`, of at most 72 sectors the nearest;
  /// of a radar `t` and the strongest points `cm` (x, y, cm/s). Of a station's trackers the first.
  std::string latest = {};
};

/// Decodes the bytes of one device to messages.
class DeviceDecoder {
 public:
  /// Takes each message, in the order of the bytes.
  using Sink = std::function<void(DecodedMessage)>;

  virtual ~DeviceDecoder() = default;
  /// Takes the next bytes, the last of which arrived at `arrived`.
  virtual void feed(decode::Bytes bytes, LogTime arrived, const Sink& sink) = 0;
  /// Results so far.
  [[nodiscard]] virtual DecodingStatus status() const = 0;
};

/// What a decoder has to know of a device.
struct DeviceDescription {
  std::string name;           ///< of the sensor: frame of its messages, first part of its topics
  std::string kind = "raw";   ///< one of device_kinds()
  int baud = 115200;          ///< of its line, positive: determines the delay of the bytes
  std::string configuration;  ///< text of a TI radar's .cfg, if there is one
};

/// The kinds that `make_decoder` supports.
[[nodiscard]] std::vector<std::string> device_kinds();

/// Errors: an unknown kind, no positive baud rate, an invalid configuration. Kind "raw" decodes
/// nothing.
[[nodiscard]] Result<std::unique_ptr<DeviceDecoder>> make_decoder(const DeviceDescription& device);

}  // namespace wayfare::logger
