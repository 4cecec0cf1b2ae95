#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include <wayfare/io/map_image.hpp>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto yaml = wayfare::io::parse_map_yaml(text, "fuzz");
  if (yaml && !(yaml->resolution_m > 0.0)) std::abort();
  const auto image = wayfare::io::parse_pgm(text, "fuzz");
  if (image && image->pixels.size() != image->width * image->height) std::abort();
  return 0;
}
