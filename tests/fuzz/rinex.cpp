#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include <wayfare/gnss/single_point.hpp>
#include <wayfare/io/rinex.hpp>

// Observations, messages, or both in one text: what is read is passed to the solution.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace wayfare;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const std::size_t middle = std::min(text.find('\x01'), text.size());
  const auto obs = io::parse_rinex_observations(text.substr(0, middle), "fuzz");
  const auto nav =
      io::parse_rinex_navigation(middle < text.size() ? text.substr(middle + 1) : text, "fuzz");
  if (obs && obs->epochs.empty()) std::abort();
  if (nav) {
    for (const SatelliteId satellite : nav->ephemerides.satellites())
      for (const Ephemeris& e : nav->ephemerides.of(satellite))
        if (!satellite_state(e, reference_time(e)).position_ecef_m.allFinite()) std::abort();
  }
  if (!obs || !nav) return 0;
  for (std::size_t i = 0; i < obs->epochs.size() && i < 3; ++i) {
    const auto point = single_point(obs->epochs[i], nav->ephemerides);
    if (point && !point->position_ecef_m.allFinite()) std::abort();
  }
  return 0;
}
