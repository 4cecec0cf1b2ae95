#include <cstddef>
#include <cstdint>

#include <wayfare/decode/ti_decoder.hpp>
#include <wayfare/decode/ti_frame.hpp>
#include <wayfare/decode/ti_refusal.hpp>
#include <wayfare/decode/ti_tracking.hpp>
#include "decoders.hpp"

namespace {

using namespace wayfare;

void use(decode::Bytes bytes) {
  static const decode::TiDecoder fresh{};
  decode::TiClock clock;
  fuzz::decode(bytes, fresh, [&](const decode::TiFrame& frame) {
    std::uint32_t items = 0;
    frame.for_each([&](std::uint32_t, decode::Bytes) { ++items; });
    fuzz::require(items == frame.header().tlvs);
    fuzz::require(to_radar_scan(frame, LogTime{}, 0.1).points.size() <= frame.size());
    static_cast<void>(frame.statistics());
    static_cast<void>(frame.temperature());
    static_cast<void>(clock.at(frame.header()));
    const decode::TiTargets targets = ti_targets(frame);
    for (std::size_t i = 0; i < targets.size(); ++i) static_cast<void>(targets[i]);
    for (std::size_t i = 0; i < ti_height_count(frame); ++i) static_cast<void>(ti_height(frame, i));
    static_cast<void>(ti_target_index(frame));
    static_cast<void>(ti_presence(frame));
    static_cast<void>(ti_vital_signs(frame));
  });
}

/// The bytes behind a header of their length with a checksum that is right.
void use_behind_header(decode::Bytes bytes, std::size_t header, std::size_t length_at) {
  if (bytes.size() < header) return;
  std::vector<std::uint8_t> frame(bytes.begin(), bytes.end());
  std::copy(decode::kTiMagic.begin(), decode::kTiMagic.end(), frame.begin());
  decode::store_le(static_cast<std::uint32_t>(frame.size()), &frame[length_at]);
  decode::store_le(std::uint16_t{0}, &frame[header - 2]);
  std::uint32_t sum = 0;
  for (std::size_t i = 0; i < header; i += 2) sum += decode::load_le<std::uint16_t>(&frame[i]);
  decode::store_le(static_cast<std::uint16_t>(~((sum >> 16) + (sum & 0xFFFFU))),
                   &frame[header - 2]);
  use(frame);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const decode::Bytes bytes(data, size);
  use(bytes);
  use_behind_header(bytes, 48, 12);
  use_behind_header(bytes, 52, 20);
  return 0;
}
