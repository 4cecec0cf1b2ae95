#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include <wayfare/io/carmen.hpp>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto log = wayfare::io::parse_carmen(text, "fuzz");
  if (log && log->recording.scans.empty()) std::abort();
  return 0;
}
