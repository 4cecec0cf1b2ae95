#include <wayfare/decode/rplidar_scan.hpp>

#include "logger/devices/device_decoders.hpp"

namespace wayfare::logger {
namespace {

class RplidarDevice final : public DeviceDecoder {
 public:
  explicit RplidarDevice(const DeviceDescription& device)
      : name_(device.name),
        stream_(device.baud),
        scans_(json_stream("/" + device.name + "/scan", laser_scan_schema())) {}

  void feed(decode::Bytes bytes, LogTime arrived, const Sink& sink) override {
    stream_.feed(bytes, arrived, [&](const decode::RplidarRevolution& turn) {
      const LaserScan scan = decode::to_laser_scan(turn);
      ++messages_;
      last_points_ = turn.points.size();
      sink({scans_, scan.time, laser_scan_json(scan, name_)});
    });
  }

  [[nodiscard]] DecodingStatus status() const override {
    const auto& s = stream_.statistics();
    return {messages_, s.skipped_bytes, s.malformed + s.checksum_failures,
            messages_ == 0 ? "" : std::to_string(last_points_) + " points a turn"};
  }

 private:
  std::string name_;
  decode::RplidarStream stream_;
  std::shared_ptr<const Stream> scans_;
  std::uint64_t messages_ = 0;
  std::size_t last_points_ = 0;
};

}  // namespace

Result<std::unique_ptr<DeviceDecoder>> make_rplidar_decoder(const DeviceDescription& device) {
  return std::unique_ptr<DeviceDecoder>(new RplidarDevice(device));
}

}  // namespace wayfare::logger
