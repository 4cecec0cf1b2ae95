#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include <wayfare/io/nav_text.hpp>

namespace {

void require(bool good) {
  if (!good) std::abort();
}

}  // namespace

// The first byte selects the reader; accepted values are valid and read back unchanged.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace wayfare;
  if (size == 0) return 0;
  const std::string_view text(reinterpret_cast<const char*>(data) + 1, size - 1);
  switch (data[0] % 5) {
    case 0: {
      const auto file = io::parse_imu(text, "fuzz");
      if (!file) break;
      require(!file->samples.empty() && file->samples.size() == file->ends.size());
      for (const ImuSample& s : file->samples)
        require(s.angular_rate_radps.allFinite() && s.specific_force_mps2.allFinite());
      const auto again = io::parse_imu(io::format_imu(file->samples), "again");
      require(again && again->samples.size() == file->samples.size());
      break;
    }
    case 1: {
      const auto file = io::parse_ranges(text, "fuzz");
      if (!file) break;
      const auto again = io::parse_ranges(io::format_ranges(file->epochs), "again");
      require(again && again->epochs.size() == file->epochs.size());
      break;
    }
    case 2: {
      const auto file = io::parse_fixes(text, "fuzz");
      if (!file) break;
      require(file->fixes.size() == file->qualities.size());
      for (const GnssFix& f : file->fixes) require(std::isfinite(f.position.height_m));
      break;
    }
    case 3: {
      const auto file = io::parse_nav(text, "fuzz");
      if (file)
        for (const NavState& s : file->trajectory) require(s.velocity_ned_mps.allFinite());
      break;
    }
    default: {
      const auto tags = io::parse_time_tags(text, "fuzz");
      if (!tags) break;
      for (std::size_t i = 1; i < tags->tags.size(); ++i)
        require(tags->tags[i - 1].bytes <= tags->tags[i].bytes);
    }
  }
  return 0;
}
