#include <cstddef>
#include <cstdint>
#include <memory>

#include <wayfare/decode/rplidar_conf.hpp>
#include <wayfare/decode/rplidar_decoder.hpp>
#include <wayfare/decode/rplidar_scan.hpp>
#include "decoders.hpp"

namespace {

using namespace wayfare;

// Checksums would reject most capsules: pairs of them as their contents.
void unpack(decode::Bytes bytes, decode::RplidarResponse response) {
  decode::RplidarUnpacker unpacker;
  const std::size_t n = decode::rplidar_packet_bytes(response);
  for (std::size_t at = 0; n > 5 && at + n <= bytes.size(); at += n) {
    const std::vector<std::uint8_t> capsule(bytes.begin() + long(at), bytes.begin() + long(at + n));
    unpacker.add({response, false, at, capsule}, [](std::span<const decode::RplidarPoint> points) {
      for (const auto& point : points) fuzz::require(point.angle_deg() < 360.0);
    });
  }
}

}  // namespace

// The first byte selects the response in which the stream begins, or any, to be found.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace wayfare;
  using decode::RplidarResponse;
  if (size == 0) return 0;
  constexpr RplidarResponse kInside[] = {RplidarResponse::none,       RplidarResponse::node,
                                         RplidarResponse::express,    RplidarResponse::ultra,
                                         RplidarResponse::dense,      RplidarResponse::hq,
                                         RplidarResponse::ultra_dense};
  const RplidarResponse inside = kInside[data[0] % 7];
  unpack(decode::Bytes(data + 1, size - 1), inside);
  const decode::RplidarDecoder fresh{data[0] >= 128 ? decode::RplidarFraming::running()
                                                    : decode::RplidarFraming(inside)};
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
