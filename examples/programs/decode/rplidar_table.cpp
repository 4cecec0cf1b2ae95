#include <memory>

#include <wayfare/decode/rplidar_decoder.hpp>
#include <wayfare/decode/rplidar_scan.hpp>
#include <wayfare/io/time_text.hpp>

#include "tables.hpp"

namespace wayfare::examples {

namespace {

/// Writes the points of packets and counts revolutions.
class Writer {
 public:
  explicit Writer(const RplidarTableOptions& options) : options_(options) {}

  void add(const decode::RplidarPacket& packet) {
    using decode::RplidarResponse;
    if (packet.is_descriptor()) ++descriptors_;
    if (!packet.is_descriptor() && packet.response() == RplidarResponse::sample_rate)
      rate_ = decode::rplidar_sample_rate(packet.bytes()).value_or(rate_);
    const Duration sample = sample_of(packet.response());
    const auto end = static_cast<double>(packet.position() + packet.bytes().size());
    const LogTime last = LogTime::from_seconds(10.0 * end / options_.baud) -
                         decode::rplidar_delay(packet.response(), sample, options_.baud);
    unpacker_.add(packet, [&](std::span<const decode::RplidarPoint> points) {
      for (std::size_t i = 0; i < points.size(); ++i)
        add(points[i], last - sample * static_cast<std::int64_t>(points.size() - 1 - i));
    });
  }

  [[nodiscard]] std::string contents() const {
    return std::to_string(points_) + " points in " + std::to_string(revolutions_) +
           " revolutions, after " + std::to_string(descriptors_) + " descriptors";
  }
  [[nodiscard]] std::string take() && { return std::move(csv_).take(); }

 private:
  [[nodiscard]] Duration sample_of(decode::RplidarResponse answer) const {
    const bool node = answer == decode::RplidarResponse::node;
    const double us = options_.sample_us > 0.0 ? options_.sample_us
                      : node                   ? rate_.standard_us
                                               : rate_.express_us;
    return from_seconds(1e-6 * us);
  }
  void add(const decode::RplidarPoint& p, LogTime time) {
    ++points_;
    revolutions_ += p.start_of_revolution ? 1 : 0;
    csv_.row()
        .field(io::format_nanoseconds(time.nanoseconds()))
        .field(revolutions_)
        .field(p.angle_deg())
        .field(p.distance_m());
    csv_.field(p.quality).field(p.start_of_revolution ? 1 : 0);
  }

  RplidarTableOptions options_;
  Csv csv_{"t_s,turn,angle_deg,distance_m,quality,start_of_turn"};
  decode::RplidarUnpacker unpacker_;
  decode::RplidarSampleRate rate_{500, 250};
  std::size_t points_ = 0, revolutions_ = 0, descriptors_ = 0;
};

}  // namespace

Table rplidar_table(decode::Bytes capture, const RplidarTableOptions& options) {
  const auto decoder =
      std::make_unique<decode::RplidarDecoder>(decode::RplidarFraming(options.inside));
  Writer writer(options);
  const auto sink = [&](const decode::RplidarPacket& packet) { writer.add(packet); };
  decoder->feed(capture, sink);
  decoder->finish(sink);
  const std::string contents = writer.contents();
  return {std::move(writer).take(), decoder->statistics(), contents};
}

}  // namespace wayfare::examples
