#include <wayfare/logger/device_decoder.hpp>

#include <array>
#include <cstdio>
#include <map>
#include <optional>
#include <string_view>
#include <utility>

#include <wayfare/decode/rplidar_stream.hpp>
#include <wayfare/decode/rplidar_sweep.hpp>
#include <wayfare/logger/messages.hpp>

#include "logger/status_sample.hpp"

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

const RadarScan& measured(const RadarScan& scan) { return scan; }
LaserScan measured(const decode::RplidarRevolution& turn) { return decode::to_laser_sweep(turn); }

std::string json_of(const RadarScan& scan, const std::string& frame) {
  return point_cloud_json(scan, frame);
}
std::string json_of(const LaserScan& scan, const std::string& frame) {
  return laser_scan_json(scan, frame);
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
      const auto& measurement = measured(scan);
      latest_ = status_sample(measurement);
      sink({stream_, measurement.time, json_of(measurement, name_)});
    });
  }

  [[nodiscard]] DecodingStatus status() const override {
    const auto& s = scans_.statistics();
    return {messages_, s.skipped_bytes, s.malformed + s.checksum_failures,
            messages_ == 0 ? "" : std::to_string(last_points_) + unit_, latest_};
  }

 private:
  std::string name_, unit_;
  Scans scans_;
  std::shared_ptr<const Stream> stream_;
  std::uint64_t messages_ = 0;
  std::size_t last_points_ = 0;
  std::string latest_;
};

/// An MTi on its own line, or a station with its trackers, each of which has a stream.
class XsensDevice final : public DeviceDecoder {
 public:
  explicit XsensDevice(const DeviceDescription& device)
      : name_(device.name),
        samples_(device.baud),
        lone_(json_stream("/" + device.name + "/imu", imu_schema())) {}

  void feed(decode::Bytes bytes, LogTime arrived, const Sink& sink) override {
    samples_.feed(bytes, arrived,
                  [&](std::optional<std::uint32_t> tracker, const MargSample& sample) {
                    give(tracker ? stream_of(*tracker) : lone_, sample, sink);
                  });
  }

  [[nodiscard]] DecodingStatus status() const override {
    const auto& s = samples_.statistics();
    return {messages_, s.skipped_bytes, s.malformed + s.checksum_failures, sample_, latest_};
  }

 private:
  void give(const std::shared_ptr<const Stream>& stream, const MargSample& marg, const Sink& sink) {
    ++messages_;
    std::array<char, 80> text{};
    std::snprintf(text.data(), text.size(), "%.2f m/s2, %.3f rad/s",
                  marg.specific_force_mps2.norm(), marg.angular_rate_radps.norm());
    sample_ = text.data();
    if (!shown_) shown_ = stream;
    if (stream == shown_) latest_ = status_sample(marg);
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
  XsensStream samples_;
  std::shared_ptr<const Stream> lone_;
  std::map<std::uint32_t, std::shared_ptr<const Stream>> trackers_;  ///< bounded by the station
  std::uint64_t messages_ = 0;
  std::shared_ptr<const Stream> shown_;  ///< whose samples are in the status
  std::string sample_, latest_;
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
