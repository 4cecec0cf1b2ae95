#include <cstddef>
#include <cstdint>

#include <wayfare/decode/ti_decoder.hpp>
#include <wayfare/decode/ti_frame.hpp>
#include <wayfare/decode/ti_refusal.hpp>
#include <wayfare/decode/ti_tracking.hpp>
#include "decoders.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace wayfare;
  static const decode::TiDecoder fresh{};
  decode::TiClock clock;
  fuzz::decode(decode::Bytes(data, size), fresh, [&](const decode::TiFrame& frame) {
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
  return 0;
}
