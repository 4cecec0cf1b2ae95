#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include <wayfare/io/map_image.hpp>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto file = wayfare::io::parse_points(text, "fuzz");
  if (!file) return 0;
  if (file->points_m.empty()) std::abort();
  for (const Eigen::Vector3d& p : file->points_m)
    if (!p.allFinite()) std::abort();
  return 0;
}
