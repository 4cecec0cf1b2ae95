#include <cstddef>
#include <cstdint>
#include <memory>

#include <wayfare/decode/rplidar_conf.hpp>
#include <wayfare/decode/rplidar_decoder.hpp>
#include <wayfare/decode/rplidar_scan.hpp>
#include "decoders.hpp"

// The first byte selects the response in which the stream begins.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace wayfare;
  using decode::RplidarResponse;
  if (size == 0) return 0;
  constexpr RplidarResponse kInside[] = {RplidarResponse::none,       RplidarResponse::node,
                                         RplidarResponse::express,    RplidarResponse::ultra,
                                         RplidarResponse::dense,      RplidarResponse::hq,
                                         RplidarResponse::ultra_dense};
  const decode::RplidarDecoder fresh{decode::RplidarFraming(kInside[data[0] % 7])};
  decode::RplidarUnpacker unpacker;
  const auto revolutions = std::make_unique<decode::RplidarRevolutions<500>>();
  const auto revolution = [](const decode::RplidarRevolution& t) {
    fuzz::require(to_laser_scan(t, {90}).ranges_m.size() == 90);
  };
  fuzz::decode(decode::Bytes(data + 1, size - 1), fresh, [&](const decode::RplidarPacket& p) {
    static_cast<void>(decode::rplidar_info(p.bytes()));
    static_cast<void>(decode::rplidar_health(p.bytes()));
    static_cast<void>(decode::rplidar_sample_rate(p.bytes()));
    static_cast<void>(decode::rplidar_conf(p.bytes()));
    static_cast<void>(decode::rplidar_conf_set(p.bytes()));
    unpacker.add(p, [&](std::span<const decode::RplidarPoint> points) {
      for (const auto& point : points) fuzz::require(point.angle_deg() < 360.0);
      revolutions->add(points, LogTime{}, Duration(250'000), revolution);
    });
  });
  revolutions->finish(revolution);
  return 0;
}
