#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include <wayfare/io/nav_text.hpp>
#include <wayfare/io/observations.hpp>

namespace {

void require(bool good) {
  if (!good) std::abort();
}

}  // namespace

// Streams of receivers, GPX and KML as files: accepted values are finite.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace wayfare;
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  if (const auto file = io::parse_fixes(bytes, "fuzz"); file) {
    require(!file->fixes.empty() && file->fixes.size() == file->qualities.size());
    for (const GnssFix& fix : file->fixes) {
      require(std::isfinite(fix.position.height_m));
      require(!fix.velocity_ned_mps || fix.velocity_ned_mps->allFinite());
      require(fix.position_covariance_ned_m2.diagonal().minCoeff() > 0.0);
    }
  }
  if (const auto file = io::parse_observations(bytes, "fuzz"); file) require(!file->epochs.empty());
  return 0;
}
