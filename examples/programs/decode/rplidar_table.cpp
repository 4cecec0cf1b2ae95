#include <span>
#include <utility>

#include <wayfare/decode/rplidar_decoder.hpp>
#include <wayfare/decode/rplidar_scan.hpp>
#include <wayfare/io/text_file.hpp>

#include "tables.hpp"

namespace wayfare::examples {

Table rplidar_table(const Capture& capture, const RplidarTableOptions& options) {
  Csv csv("t_s,turn,angle_deg,distance_m,quality,start_of_turn");
  decode::RplidarUnpacker unpacker;
  decode::RplidarSampleRate rate{500, 250};
  std::size_t points = 0, revolutions = 0, descriptors = 0;
  const auto take = [&](const decode::RplidarPacket& packet) {
    using decode::RplidarResponse;
    if (packet.is_descriptor()) {
      ++descriptors;
    } else if (packet.response() == RplidarResponse::sample_rate) {
      rate = decode::rplidar_sample_rate(packet.bytes()).value_or(rate);
    }
    const bool node = packet.response() == RplidarResponse::node;
    const double sample_us = options.sample_us > 0.0 ? options.sample_us
                             : node                  ? rate.standard_us
                                                     : rate.express_us;
    const Duration sample = from_seconds(1e-6 * sample_us);
    const std::uint64_t end = packet.position() + packet.bytes().size();
    const LogTime last = capture.arrival(end, options.baud) -
                         decode::rplidar_delay(packet.response(), sample, options.baud);
    unpacker.add(packet, [&](std::span<const decode::RplidarPoint> found) {
      points += found.size();
      auto time = last - sample * static_cast<std::int64_t>(found.size() - 1);
      for (const decode::RplidarPoint& p : found) {
        revolutions += p.start_of_revolution ? 1 : 0;
        csv.row().field(io::format_nanoseconds(time.nanoseconds())).field(revolutions);
        csv.field(p.angle_deg()).field(p.distance_m());
        csv.field(p.quality).field(p.start_of_revolution ? 1 : 0);
        time += sample;
      }
    });
  };
  const auto statistics = decode_all<decode::RplidarDecoder>(
      capture.view(), take, decode::RplidarFraming(options.inside));
  return {std::move(csv).take(), statistics,
          std::to_string(points) + " points in " + std::to_string(revolutions) +
              " revolutions, after " + std::to_string(descriptors) + " descriptors"};
}

}  // namespace wayfare::examples
