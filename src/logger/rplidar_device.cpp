#include <wayfare/decode/rplidar_decoder.hpp>
#include <wayfare/decode/rplidar_points.hpp>
#include <wayfare/decode/rplidar_scan.hpp>

#include "device_decoders.hpp"

namespace wayfare::logger {
namespace {

/// Samples of an A1 until the device says otherwise: 2000 nodes a second, 4000 in capsules.
constexpr decode::RplidarSampleRate kUsualRate = {500, 250};

class RplidarDevice final : public DeviceDecoder {
 public:
  explicit RplidarDevice(const DeviceDescription& device)
      : name_(device.name),
        baud_(device.baud),
        scans_(json_stream("/" + device.name + "/scan", laser_scan_schema())) {}

  void feed(decode::Bytes bytes, LogTime arrived, const Sink& sink) override {
    fed_ += bytes.size();
    decoder_.feed(bytes, [&](const decode::RplidarPacket& packet) { take(packet, arrived, sink); });
  }

  [[nodiscard]] DecodingStatus status() const override {
    const auto& s = decoder_.statistics();
    return {messages_, s.skipped_bytes, s.malformed + s.checksum_failures,
            messages_ == 0 ? "" : std::to_string(last_points_) + " points a turn"};
  }

 private:
  using Answer = decode::RplidarAnswer;

  void take(const decode::RplidarPacket& packet, LogTime arrived, const Sink& sink) {
    if (packet.answer() == Answer::sample_rate && !packet.is_descriptor()) {
      rate_ = decode::rplidar_sample_rate(packet.bytes()).value_or(rate_);
      return;
    }
    // A new request began in the middle of a turn.
    if (packet.is_descriptor()) turns_.finish([](const decode::RplidarTurn&) {});
    const bool nodes = packet.answer() == Answer::node;
    const Duration sample = std::chrono::microseconds(nodes ? rate_.standard_us : rate_.express_us);
    const std::uint64_t end = packet.position() + packet.bytes().size();
    const LogTime last = arrived - line_time(fed_ - end, baud_) -
                         decode::rplidar_delay(packet.answer(), sample, baud_);
    unpacker_.add(packet, [&](std::span<const decode::RplidarPoint> points) {
      turns_.add(points, last, sample, [&](const decode::RplidarTurn& turn) {
        if (turn.whole) give(turn, sink);
      });
    });
  }

  void give(const decode::RplidarTurn& turn, const Sink& sink) {
    const LaserScan scan = decode::to_laser_scan(turn);
    ++messages_;
    last_points_ = turn.points.size();
    sink({scans_, scan.time, laser_scan_json(scan, name_)});
  }

  std::string name_;
  int baud_;
  std::shared_ptr<const Stream> scans_;
  decode::RplidarDecoder decoder_;
  decode::RplidarUnpacker unpacker_;
  decode::RplidarTurns<> turns_;
  decode::RplidarSampleRate rate_ = kUsualRate;
  std::uint64_t fed_ = 0, messages_ = 0;
  std::size_t last_points_ = 0;
};

}  // namespace

Result<std::unique_ptr<DeviceDecoder>> make_rplidar_decoder(const DeviceDescription& device) {
  return std::unique_ptr<DeviceDecoder>(new RplidarDevice(device));
}

}  // namespace wayfare::logger
