// Decoders on generated streams, damaged and cut at random: soak_decoders [--minutes M]. Messages
// come in order, memory stays where it was, and after any damage an intact stream is decoded as by
// a fresh decoder.

#include <algorithm>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "abuse/decode_streams.hpp"
#include "soak/soak.hpp"

namespace wayfare::tests {
namespace {

void damage(Stream& bytes, Rng& rng) {
  for (auto k = 1 + rng.below(40); k > 0; --k) {
    const std::size_t at = rng.below(bytes.size());
    const auto place = bytes.begin() + static_cast<std::ptrdiff_t>(at);
    switch (rng.below(3)) {
      case 0:
        *place = static_cast<std::uint8_t>(rng());
        break;
      case 1:
        bytes.erase(place, place + static_cast<std::ptrdiff_t>(std::min<std::size_t>(
                                       1 + rng.below(50), bytes.size() - at)));
        break;
      default:
        bytes.insert(place, 1 + rng.below(20), static_cast<std::uint8_t>(rng()));
    }
  }
}

/// Feeds pieces of any length; the number of messages. Their positions increase.
template <class Decoder>
std::uint64_t feed(Decoder& decoder, const Stream& bytes, Rng& rng, const char* name) {
  std::uint64_t messages = 0, last = 0;
  bool first = true;
  for (std::size_t at = 0; at < bytes.size();) {
    const std::size_t n = std::min<std::size_t>(1 + rng.below(4000), bytes.size() - at);
    decoder.feed(std::span(bytes).subspan(at, n), [&](const auto& message) {
      if (!first && message.position() <= last)
        soak::fail(std::string(name) + ": messages out of order");
      last = message.position();
      first = false;
      ++messages;
    });
    at += n;
  }
  decoder.finish([&](const auto&) { ++messages; });
  return messages;
}

/// One device: damaged streams, then an intact one, which costs at most what the damage left open.
template <class Device>
std::uint64_t round(const Device& device, Rng& rng) {
  const auto decoder = device.fresh();
  std::uint64_t bytes = 0;
  for (int k = 0; k < 20; ++k) {
    Stream stream = device.stream;
    damage(stream, rng);
    bytes += stream.size();
    (void)feed(*decoder, stream, rng, device.name);
  }
  const std::uint64_t whole = feed(*device.fresh(), device.stream, rng, device.name);
  const std::uint64_t again = feed(*decoder, device.stream, rng, device.name);
  soak::require(again == whole, std::string(device.name) + ": " + std::to_string(again) +
                                    " messages of an intact stream, " + std::to_string(whole) +
                                    " by a fresh decoder");
  return bytes + 2 * device.stream.size();
}

}  // namespace
}  // namespace wayfare::tests

int main(int argc, char** argv) {
  using namespace wayfare;
  soak::Time time(argc, argv,
                  "Feeds all decoders with damaged streams. 100 GB take about half an hour.");
  Rng rng(1);
  double bytes = 0.0, begin_MB = 0.0;
  for (std::uint64_t seed = 1; !time.is_over(); ++seed) {
    tests::for_every_decoder(
        [&](const auto& device) { bytes += static_cast<double>(tests::round(device, rng)); }, seed);
    if (seed == 20) begin_MB = soak::memory_MB();
    soak::require(seed < 20 || soak::memory_MB() < begin_MB + 20.0, "memory grows");
    time.show(std::to_string(bytes / 1e9) + " GB");
  }
  std::printf("%.2f GB decoded, %.0f MB of memory\n", bytes / 1e9, soak::memory_MB());
  return 0;
}
