#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>
#include <variant>

#include <wayfare/io/g2o.hpp>
#include <wayfare/io/landmark_graph.hpp>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  using wayfare::io::IndefiniteInformation;
  const auto strict = wayfare::io::parse_g2o(text, "fuzz");
  const auto lenient =
      wayfare::io::parse_g2o(text, "fuzz", {.indefinite = IndefiniteInformation::project});
  if (strict && !lenient) std::abort();
  // What is read is a graph, and reads back.
  if (strict)
    std::visit(
        [](const auto& file) {
          (void)wayfare::io::to_factor_graph(file);
          if (!wayfare::io::parse_g2o(wayfare::io::format_g2o(file), "again")) std::abort();
        },
        *strict);
  return 0;
}
