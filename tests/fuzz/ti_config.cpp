#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include <wayfare/decode/ti_decoder.hpp>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace wayfare;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto config = decode::parse_ti_config(text, "fuzz");
  if (!config) {
    if (config.error().message.empty()) std::abort();
    return 0;
  }
  const decode::TiLimits l = decode::limits_of(*config);
  const bool good = l.range_step_m > 0.0 && l.speed_step_mps > 0.0 && l.range_bins > 0 &&
                    l.azimuth_antennas > 0 && std::isfinite(l.max_speed_mps + l.max_range_m);
  if (!good) std::abort();
  return 0;
}
