#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include <wayfare/io/g2o.hpp>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  using wayfare::io::IndefiniteInformation;
  const auto strict = wayfare::io::parse_g2o(text, "fuzz");
  const auto lenient =
      wayfare::io::parse_g2o(text, "fuzz", {.indefinite = IndefiniteInformation::project});
  if (strict && !lenient) std::abort();
  return 0;
}
