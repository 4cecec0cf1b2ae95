#include <cstddef>
#include <cstdint>
#include <memory>

#include <wayfare/decode/awinda.hpp>
#include <wayfare/decode/mt_raw.hpp>
#include <wayfare/decode/mt_sample.hpp>
#include <wayfare/decode/mt_setup.hpp>
#include <wayfare/decode/xbus.hpp>
#include "decoders.hpp"

namespace {

using namespace wayfare;

void use(decode::Bytes data, const decode::MtLegacyLayout& layout,
         decode::AwindaStation<4, 8>& station) {
  if (const auto sample = decode::mt_sample(data)) {
    if (const auto imu = to_imu_sample(*sample, LogTime{}))
      fuzz::require(imu->angular_rate_radps.allFinite() && imu->specific_force_mps2.allFinite());
    static_cast<void>(to_marg_sample(*sample, LogTime{}));
  }
  static_cast<void>(decode::mt_legacy_sample(data, layout));
  static_cast<void>(decode::mt_raw_readings(data));
  static_cast<void>(decode::mt_full_snapshot(data));
  for (const bool right : {false, true}) static_cast<void>(decode::mt_glove(data, right));
  if (const auto satellites = decode::mt_satellites(data))
    for (std::size_t i = 0; i < satellites->size(); ++i) static_cast<void>((*satellites)[i]);
  if (const auto outputs = decode::mt_outputs(data))
    for (std::size_t i = 0; i < outputs->size(); ++i) static_cast<void>((*outputs)[i]);
  if (const auto profiles = decode::mt_filter_profiles(data))
    for (std::size_t i = 0; i < profiles->size(); ++i)
      fuzz::require((*profiles)[i].name().size() <= 20);
  if (const auto profile = decode::mt_filter_profile(data))
    fuzz::require(profile->name().size() <= 20);
  if (const auto c = decode::awinda_configuration(data))
    for (std::size_t i = 0; i < c->trackers; ++i) static_cast<void>(c->tracker(i));
  if (const auto snapshot = decode::awinda_snapshot(data)) {
    station.add(*snapshot, [](const decode::AwindaMotion& m) {
      fuzz::require(m.frames > 0 && m.acceleration_mps2.allFinite() && m.rate_radps.allFinite());
    });
  }
}

}  // namespace

// As a stream and, since checksums would reject most contents, as the contents of one message.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 6) return 0;
  const decode::MtLegacyLayout layout{decode::load_be<std::uint16_t>(data),
                                      decode::load_be<std::uint32_t>(data + 2)};
  const auto station = std::make_unique<decode::AwindaStation<4, 8>>(0.01);
  use(decode::Bytes(data + 6, size - 6), layout, *station);
  using Decoder = decode::StreamDecoder<decode::BasicXbusFraming<2048>>;
  static const Decoder fresh{};
  fuzz::decode(decode::Bytes(data, size), fresh,
               [&](const decode::XbusMessage& m) { use(m.data(), layout, *station); });
  station->finish([](const decode::AwindaMotion&) {});
  return 0;
}
