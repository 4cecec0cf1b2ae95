#include <wayfare/decode/ti_decoder.hpp>
#include <wayfare/logger/streams.hpp>

#include "logger/devices/device_decoders.hpp"

namespace wayfare::logger {
namespace {

class TiDevice final : public DeviceDecoder {
 public:
  TiDevice(const DeviceDescription& device, double speed_step_mps)
      : name_(device.name),
        stream_(device.baud, speed_step_mps),
        points_(json_stream("/" + device.name + "/points", point_cloud_schema())) {}

  void feed(decode::Bytes bytes, LogTime arrived, const Sink& sink) override {
    stream_.feed(bytes, arrived, [&](const RadarScan& scan) {
      ++messages_;
      last_points_ = scan.points.size();
      sink({points_, scan.time, point_cloud_json(scan, name_)});
    });
  }

  [[nodiscard]] DecodingStatus status() const override {
    const auto& s = stream_.statistics();
    return {messages_, s.skipped_bytes, s.malformed,
            messages_ == 0 ? "" : std::to_string(last_points_) + " points"};
  }

 private:
  std::string name_;
  TiStream stream_;
  std::shared_ptr<const Stream> points_;
  std::uint64_t messages_ = 0;
  std::size_t last_points_ = 0;
};

}  // namespace

Result<std::unique_ptr<DeviceDecoder>> make_ti_decoder(const DeviceDescription& device) {
  double speed_step_mps = 0.0;
  if (!device.configuration.empty()) {
    const auto config = decode::parse_ti_config(device.configuration, device.name);
    if (!config) return config.error();
    speed_step_mps = decode::limits_of(*config).speed_step_mps;
  }
  return std::unique_ptr<DeviceDecoder>(new TiDevice(device, speed_step_mps));
}

}  // namespace wayfare::logger
