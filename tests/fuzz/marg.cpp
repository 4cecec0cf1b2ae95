#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include <wayfare/io/nav_text.hpp>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  wayfare::io::MargFormat format;
  if (text.starts_with("F32 ")) {
    format.columns.columns = {"gx_radps", "gy_radps", "gz_radps", "ax_g", "ay_g", "az_g"};
    format.period_s = 0.01;
  }
  const auto file = wayfare::io::parse_marg(text, "fuzz", format);
  if (!file) return 0;
  if (file->samples.empty() || file->moving.size() != file->samples.size()) std::abort();
  const std::string once = wayfare::io::format_marg(file->samples);
  const auto again = wayfare::io::parse_marg(once, "again");
  if (!again || again->samples.size() != file->samples.size()) std::abort();
  return 0;
}
