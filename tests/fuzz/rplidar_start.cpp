#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>

#include <wayfare/decode/rplidar_start.hpp>
#include <wayfare/decode/rplidar_stream.hpp>
#include "decoders.hpp"

// A line that answers anything, in pieces of up to 64 bytes at any times.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace wayfare;
  if (size < 2) return 0;
  decode::RplidarStart start(data[0] % 2 == 1 ? "typical" : "Boost");
  const auto stream = std::make_unique<decode::RplidarStream>(115200);
  const std::size_t piece = 1U + data[1] % 64U;
  LogTime now;
  for (std::size_t at = 2; at < size; at += piece) {
    now += std::chrono::milliseconds(data[at] % 200);
    const decode::Bytes bytes(data + at, std::min(piece, size - at));
    stream->feed(bytes, now, [](const decode::RplidarRevolution& r) { fuzz::require(r.whole); });
    fuzz::require(start.step(bytes, now).size <= 16);
  }
  fuzz::require(start.identity().text().size() < 1000);
  return 0;
}
