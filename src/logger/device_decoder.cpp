#include <wayfare/logger/device_decoder.hpp>

#include <algorithm>
#include <array>
#include <cstdio>
#include <map>
#include <optional>
#include <string_view>
#include <utility>

#include <wayfare/decode/awinda.hpp>
#include <wayfare/decode/mt_sample.hpp>
#include <wayfare/decode/rplidar_sweep.hpp>
#include <wayfare/decode/ti_decoder.hpp>
#include <wayfare/decode/xbus.hpp>
#include <wayfare/logger/messages.hpp>
#include <wayfare/sync/clock_fit.hpp>

namespace wayfare::logger {
namespace {

using Decoder = std::unique_ptr<DeviceDecoder>;

std::shared_ptr<const Stream> json_stream(std::string topic, const MessageSchema& schema) {
  return std::make_shared<const Stream>(
      Stream{std::move(topic), "json", std::string(schema.name), std::string(schema.json), {}});
}

class RawDevice final : public DeviceDecoder {
 public:
  void feed(decode::Bytes, LogTime, const Sink&) override {}
  [[nodiscard]] DecodingStatus status() const override { return {}; }
};

DecodedMessage message_of(const RadarScan& scan, const std::shared_ptr<const Stream>& stream,
                          const std::string& frame) {
  return {stream, scan.time, point_cloud_json(scan, frame)};
}
DecodedMessage message_of(const decode::RplidarRevolution& turn,
                          const std::shared_ptr<const Stream>& stream, const std::string& frame) {
  const LaserScan scan = decode::to_laser_sweep(turn);
  return {stream, scan.time, laser_scan_json(scan, frame)};
}

/// A device that measures scans, completed by a `Scans` from its bytes.
template <class Scans>
class ScanDevice final : public DeviceDecoder {
 public:
  template <class... Arguments>
  ScanDevice(const std::string& name, const char* topic, const MessageSchema& schema,
             const char* unit, Arguments... arguments)
      : name_(name),
        unit_(unit),
        scans_(arguments...),
        stream_(json_stream("/" + name + topic, schema)) {}

  void feed(decode::Bytes bytes, LogTime arrived, const Sink& sink) override {
    scans_.feed(bytes, arrived, [&](const auto& scan) {
      ++messages_;
      last_points_ = scan.points.size();
      sink(message_of(scan, stream_, name_));
    });
  }

  [[nodiscard]] DecodingStatus status() const override {
    const auto& s = scans_.statistics();
    return {messages_, s.skipped_bytes, s.malformed + s.checksum_failures,
            messages_ == 0 ? "" : std::to_string(last_points_) + unit_};
  }

 private:
  std::string name_, unit_;
  Scans scans_;
  std::shared_ptr<const Stream> stream_;
  std::uint64_t messages_ = 0;
  std::size_t last_points_ = 0;
};

/// An MTi on its own line, or a station with its trackers, each of which has a stream.
class XsensDevice final : public DeviceDecoder {
 public:
  explicit XsensDevice(const DeviceDescription& device)
      : name_(device.name),
        baud_(device.baud),
        lone_(json_stream("/" + device.name + "/imu", imu_schema())) {}

  void feed(decode::Bytes bytes, LogTime arrived, const Sink& sink) override {
    fed_ += bytes.size();
    decoder_.feed(bytes, [&](const decode::XbusMessage& message) {
      const std::uint64_t end = message.position() + message.bytes().size();
      const LogTime sent = arrived - decode::line_time(fed_ - end + message.bytes().size(), baud_);
      take(message, sent, sink);
    });
  }

  [[nodiscard]] DecodingStatus status() const override {
    const auto& s = decoder_.statistics();
    return {messages_, s.skipped_bytes, s.malformed + s.checksum_failures, sample_};
  }

 private:
  void take(const decode::XbusMessage& message, LogTime sent, const Sink& sink) {
    if (message.id() == decode::XbusId::configuration) {
      // A station sends its rate once; before, or if that is missed, 100 Hz.
      if (const auto c = decode::awinda_configuration(message.data()); c && c->period_s > 0.0)
        begin(c->period_s);
      return;
    }
    if (message.id() != decode::XbusId::mt_data2) return;
    if (const auto snapshot = decode::awinda_snapshot(message.data())) {
      if (!station_) begin(0.01);
      take(*snapshot, sent, sink);
    } else if (const auto sample = decode::mt_sample(message.data())) {
      take(*sample, sent, sink);
    }
  }

  void begin(double period_s) {
    period_s_ = period_s;
    station_ = std::make_unique<decode::AwindaStation<>>(period_s);
    frames_ = decode::CounterUnwrapper(std::uint64_t{1} << 32);
  }

  /// Damaged counters may add up to a time from which differences overflow.
  static Time<DeviceClock> device_time(double since_s) {
    constexpr double kFarthest_s = 1e9;
    return Time<DeviceClock>::from_seconds(std::clamp(since_s, -kFarthest_s, kFarthest_s));
  }

  void take(const decode::AwindaSnapshot& snapshot, LogTime sent, const Sink& sink) {
    // A retransmission is late by more than the line's delay; its frame counter gives its time.
    const auto device = [&](std::uint32_t frame) {
      return device_time(static_cast<double>(frames_.at(frame)) * period_s_);
    };
    if (!snapshot.retransmitted) envelope_.add(device(snapshot.frame), sent);
    station_->add(snapshot, [&](const decode::AwindaMotion& motion) {
      const LogTime time = envelope_(device(motion.frame));
      give(stream_of(motion.device), decode::to_marg_sample(motion, time), sink);
    });
  }

  void take(const decode::MtSample& sample, LogTime sent, const Sink& sink) {
    LogTime time = sent;
    if (sample.sample_time_fine)
      time = envelope_.add(
          device_time(1e-4 * static_cast<double>(fine_.at(*sample.sample_time_fine))), sent);
    const MargSample marg = decode::to_marg_sample(sample, time);
    if (marg.angular_rate_radps.allFinite() || marg.specific_force_mps2.allFinite())
      give(lone_, marg, sink);
  }

  void give(const std::shared_ptr<const Stream>& stream, const MargSample& marg, const Sink& sink) {
    ++messages_;
    std::array<char, 80> text{};
    std::snprintf(text.data(), text.size(), "%.2f m/s2, %.3f rad/s",
                  marg.specific_force_mps2.norm(), marg.angular_rate_radps.norm());
    sample_ = text.data();
    sink({stream, marg.time, imu_json(marg, name_)});
  }

  const std::shared_ptr<const Stream>& stream_of(std::uint32_t tracker) {
    auto& stream = trackers_[tracker];
    if (!stream) {
      std::array<char, 9> id{};
      std::snprintf(id.data(), id.size(), "%08X", tracker);
      stream = json_stream("/" + name_ + "/" + id.data() + "/imu", imu_schema());
    }
    return stream;
  }

  std::string name_;
  int baud_;
  std::shared_ptr<const Stream> lone_;
  std::map<std::uint32_t, std::shared_ptr<const Stream>> trackers_;
  decode::XbusDecoder decoder_;
  std::unique_ptr<decode::AwindaStation<>> station_;  ///< bounds how many trackers there are
  double period_s_ = 0.01;
  decode::CounterUnwrapper frames_{std::uint64_t{1} << 32};
  decode::CounterUnwrapper fine_{std::uint64_t{1} << 32};
  ClockEnvelope envelope_;
  std::uint64_t fed_ = 0, messages_ = 0;
  std::string sample_;
};

Result<Decoder> make_raw(const DeviceDescription&) { return Decoder(new RawDevice); }

Result<Decoder> make_ti(const DeviceDescription& device) {
  double speed_step_mps = 0.0;
  if (!device.configuration.empty()) {
    const auto config = decode::parse_ti_config(device.configuration, device.name);
    if (!config) return config.error();
    speed_step_mps = decode::limits_of(*config).speed_step_mps;
  }
  return Decoder(new ScanDevice<TiStream>(device.name, "/points", point_cloud_schema(), " points",
                                          device.baud, speed_step_mps));
}

Result<Decoder> make_rplidar(const DeviceDescription& device) {
  return Decoder(new ScanDevice<decode::RplidarStream>(device.name, "/scan", laser_scan_schema(),
                                                       " points a turn", device.baud));
}

Result<Decoder> make_xsens(const DeviceDescription& device) {
  return Decoder(new XsensDevice(device));
}

struct Kind {
  std::string_view name;
  Result<Decoder> (*make)(const DeviceDescription&);
};
constexpr std::array<Kind, 4> kKinds = {
    {{"raw", make_raw}, {"ti_mmwave", make_ti}, {"rplidar", make_rplidar}, {"xsens", make_xsens}}};

}  // namespace

std::vector<std::string> device_kinds() {
  std::vector<std::string> names;
  for (const Kind& kind : kKinds) names.emplace_back(kind.name);
  return names;
}

Result<Decoder> make_decoder(const DeviceDescription& device) {
  if (device.baud <= 0) return Error{ErrorCode::invalid, "needs a baud rate", device.name};
  std::string known;
  for (const auto& [name, make] : kKinds) {
    if (name == device.kind) return make(device);
    known.append(known.empty() ? "" : ", ").append(name);
  }
  return Error{ErrorCode::invalid, "unknown kind of device '" + device.kind + "'; known: " + known,
               device.name};
}

}  // namespace wayfare::logger
