#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace wayfare::testing {

/// The `size` low bytes of a number, the lowest first.
inline std::string little(std::uint64_t value, std::size_t size) {
  std::string out;
  for (std::size_t i = 0; i < size; ++i, value >>= 8) out += static_cast<char>(value);
  return out;
}

}  // namespace wayfare::testing
