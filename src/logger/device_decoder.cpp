#include <wayfare/logger/device_decoder.hpp>

#include <array>
#include <cstdio>
#include <map>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include <wayfare/decode/rplidar_stream.hpp>
#include <wayfare/decode/rplidar_sweep.hpp>
#include <wayfare/logger/device_messages.hpp>
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

/// A TI radar: the points of each frame, and all else it has.
class RadarDevice final : public DeviceDecoder {
 public:
  RadarDevice(const std::string& name, int baud, double speed_step_mps)
      : name_(name),
        frames_(baud, speed_step_mps),
        points_(json_stream("/" + name + "/points", point_cloud_schema())),
        others_(json_stream("/" + name + "/frame", radar_frame_schema())) {}

  void feed(decode::Bytes bytes, LogTime arrived, const Sink& sink) override {
    frames_.feed_frames(bytes, arrived, [&](const decode::TiFrame& frame, LogTime time) {
      ++messages_;
      const RadarScan scan =
          decode::to_radar_scan(frame, time, frames_.speed_step_mps(), &noise_db_);
      last_points_ = scan.points.size();
      latest_ = status_sample(scan);
      sink({points_, time, point_cloud_json(scan, name_, noise_db_)});
      sink({others_, time, radar_frame_json(radar_frame(frame, time), name_)});
    });
  }

  [[nodiscard]] DecodingStatus status() const override {
    const auto& s = frames_.statistics();
    return {
        messages_, s.skipped_bytes, s.malformed + s.checksum_failures,
        messages_ == 0 ? to_string(frames_.refusal()) : std::to_string(last_points_) + " points",
        latest_};
  }

 private:
  std::string name_;
  TiStream frames_;
  std::shared_ptr<const Stream> points_, others_;
  std::vector<float> noise_db_;
  std::uint64_t messages_ = 0;
  std::size_t last_points_ = 0;
  std::string latest_;
};

/// An RPLIDAR: each revolution as a scan, and all its nodes.
class LidarDevice final : public DeviceDecoder {
 public:
  LidarDevice(const std::string& name, int baud)
      : name_(name),
        revolutions_(baud),
        scans_(json_stream("/" + name + "/scan", laser_scan_schema())),
        nodes_(json_stream("/" + name + "/nodes", lidar_nodes_schema())) {}

  void feed(decode::Bytes bytes, LogTime arrived, const Sink& sink) override {
    revolutions_.feed(bytes, arrived, [&](const decode::RplidarRevolution& revolution) {
      ++messages_;
      last_points_ = revolution.points.size();
      const LaserScan scan = decode::to_laser_sweep(revolution, {}, &qualities_);
      latest_ = status_sample(scan);
      sink({scans_, scan.time, laser_scan_json(scan, name_, qualities_)});
      sink({nodes_, revolution.points.front().time, lidar_nodes_json(revolution.points, name_)});
    });
  }

  [[nodiscard]] DecodingStatus status() const override {
    const auto& s = revolutions_.statistics();
    return {messages_, s.skipped_bytes, s.malformed + s.checksum_failures,
            messages_ == 0 ? "" : std::to_string(last_points_) + " points a turn", latest_};
  }

 private:
  std::string name_;
  decode::RplidarStream revolutions_;
  std::shared_ptr<const Stream> scans_, nodes_;
  std::vector<float> qualities_;
  std::uint64_t messages_ = 0;
  std::size_t last_points_ = 0;
  std::string latest_;
};

/// An MTi on its own line, or a station with its trackers, each of which has streams.
class XsensDevice final : public DeviceDecoder {
 public:
  explicit XsensDevice(const DeviceDescription& device)
      : name_(device.name), samples_(device.baud), lone_(streams_of("/" + device.name)) {}

  void feed(decode::Bytes bytes, LogTime arrived, const Sink& sink) override {
    samples_.feed(
        bytes, arrived,
        [&](std::optional<std::uint32_t> tracker, const MargSample& sample) {
          give((tracker ? of(*tracker) : lone_).samples, sample, sink);
        },
        [&](std::optional<std::uint32_t> tracker, const MtState& state) {
          const Streams& streams = tracker ? of(*tracker) : lone_;
          sink({streams.states, state.time, mt_state_json(state, name_)});
        });
  }

  [[nodiscard]] DecodingStatus status() const override {
    const auto& s = samples_.statistics();
    return {messages_, s.skipped_bytes, s.malformed + s.checksum_failures, sample_, latest_};
  }

 private:
  struct Streams {
    std::shared_ptr<const Stream> samples, states;
  };

  static Streams streams_of(const std::string& topic) {
    return {json_stream(topic + "/imu", imu_schema()),
            json_stream(topic + "/state", mt_state_schema())};
  }

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

  const Streams& of(std::uint32_t tracker) {
    Streams& streams = trackers_[tracker];
    if (!streams.samples) {
      std::array<char, 9> id{};
      std::snprintf(id.data(), id.size(), "%08X", tracker);
      streams = streams_of("/" + name_ + "/" + id.data());
    }
    return streams;
  }

  std::string name_;
  XsensStream samples_;
  Streams lone_;
  std::map<std::uint32_t, Streams> trackers_;  ///< bounded by the station
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
  return Decoder(new RadarDevice(device.name, device.baud, speed_step_mps));
}

Result<Decoder> make_rplidar(const DeviceDescription& device) {
  return Decoder(new LidarDevice(device.name, device.baud));
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
