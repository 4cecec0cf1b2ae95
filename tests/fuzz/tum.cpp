#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include <wayfare/io/tum.hpp>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto file = wayfare::io::parse_tum(text, "fuzz");
  if (file && file->trajectory.empty()) std::abort();
  // Written text reads back as the same text.
  if (!file) return 0;
  const std::string once = wayfare::io::format_tum(file->trajectory);
  const auto again = wayfare::io::parse_tum(once, "again");
  if (!again || again->trajectory.size() != file->trajectory.size()) std::abort();
  return 0;
}
