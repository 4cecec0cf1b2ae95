#include <wayfare/decode/ti_config.hpp>
#include <wayfare/decode/ti_decoder.hpp>
#include <wayfare/decode/ti_radar_scan.hpp>
#include <wayfare/sync/clock_envelope.hpp>

#include "device_decoders.hpp"

namespace wayfare::logger {
namespace {

class TiDevice final : public DeviceDecoder {
 public:
  TiDevice(const DeviceDescription& device, double speed_step_mps)
      : name_(device.name),
        baud_(device.baud),
        speed_step_mps_(speed_step_mps),
        points_(json_stream("/" + device.name + "/points", point_cloud_schema())) {}

  void feed(decode::Bytes bytes, LogTime arrived, const Sink& sink) override {
    fed_ += bytes.size();
    decoder_.feed(bytes, [&](const decode::TiFrame& frame) {
      const std::uint64_t end = frame.position() + frame.bytes().size();
      // The frame was on the line from when it was built; behind its end more may have come.
      const LogTime sent = arrived - line_time(fed_ - end + frame.bytes().size(), baud_);
      const LogTime time = envelope_.add(clock_.at(frame.header()), sent);
      const RadarScan scan = decode::to_radar_scan(frame, time, speed_step_mps_);
      ++messages_;
      last_points_ = scan.points.size();
      sink({points_, time, point_cloud_json(scan, name_)});
    });
  }

  [[nodiscard]] DecodingStatus status() const override {
    const auto& s = decoder_.statistics();
    return {messages_, s.skipped_bytes, s.malformed,
            messages_ == 0 ? "" : std::to_string(last_points_) + " points"};
  }

 private:
  std::string name_;
  int baud_;
  double speed_step_mps_;
  std::shared_ptr<const Stream> points_;
  decode::TiDecoder decoder_;
  decode::TiClock clock_;
  ClockEnvelope envelope_;
  std::uint64_t fed_ = 0, messages_ = 0;
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
