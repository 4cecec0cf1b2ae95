#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include <wayfare/io/text_file.hpp>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto content = wayfare::io::decompress(text, "fuzz", {.max_bytes = 1000000});
  if (content && content->bytes.size() > 1000000) std::abort();
  return 0;
}
