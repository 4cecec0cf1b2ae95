#include <cmath>
#include <cstddef>
#include <cstdint>

#include <wayfare/decode/nmea.hpp>
#include <wayfare/decode/ubx_messages.hpp>
#include "decoders.hpp"

namespace {

using namespace wayfare;

void use(const decode::UbxMessage& m) {
  if (const auto raw = decode::rxm_rawx(m)) {
    static_cast<void>(raw->epoch());
    for (std::size_t i = 0; i < raw->size(); ++i)
      fuzz::require(raw->measurement(i).pseudorange_sigma_m > 0.0);
  }
  if (const auto frame = decode::rxm_sfrbx(m))
    for (std::size_t i = 0; i < frame->size(); ++i) static_cast<void>(frame->word(i));
  if (const auto pvt = decode::nav_pvt(m)) fuzz::require(std::isfinite(pvt->latitude_deg));
}

void use(const decode::NmeaSentence& s) {
  static_cast<void>(s.talker());
  for (std::size_t i = 0; i < 20; ++i) static_cast<void>(s.number(i));
  if (const auto fix = decode::nmea_gga(s)) fuzz::require(std::abs(fix->latitude_deg) <= 90.0);
  if (const auto motion = decode::nmea_rmc(s)) fuzz::require(motion->month >= 1);
}

/// The bytes as the payload of a message, since its checksum would reject most.
void use_as_payload(decode::UbxId id, decode::Bytes payload) {
  std::vector<std::uint8_t> bytes(payload.size() + 8);
  if (decode::write_ubx(id, payload, bytes) != 0) use(decode::UbxMessage(0, bytes));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const decode::Bytes bytes(data, size);
  static const decode::StreamDecoder<decode::BasicUbxFraming<1024>> ubx{};
  static const decode::NmeaDecoder nmea{};
  fuzz::decode(bytes, ubx, [](const decode::UbxMessage& m) { use(m); });
  fuzz::decode(bytes, nmea, [](const decode::NmeaSentence& s) { use(s); });
  for (const auto id : {decode::UbxId::rxm_rawx, decode::UbxId::rxm_sfrbx, decode::UbxId::nav_pvt})
    use_as_payload(id, bytes);
  return 0;
}
