#pragma once

// The CRC-32 of Ethernet and zlib (reversed polynomial EDB88320, initial value and final XOR all
// ones), eight bytes at a time (Kounavis and Berry 2008).

#include <array>
#include <cstddef>
#include <cstdint>

#include <wayfare/core/detail/bytes.hpp>

namespace wayfare::decode::detail {

using Crc32Tables = std::array<std::array<std::uint32_t, 256>, 8>;

/// Table k: the effect of a byte that k bytes follow.
constexpr Crc32Tables crc32_tables() {
  Crc32Tables t{};
  for (std::uint32_t i = 0; i < 256; ++i) {
    std::uint32_t sum = i;
    for (int bit = 0; bit < 8; ++bit) sum = sum >> 1 ^ ((sum & 1U) != 0 ? 0xEDB88320U : 0U);
    t[0][i] = sum;
  }
  for (std::size_t k = 1; k < 8; ++k)
    for (std::size_t i = 0; i < 256; ++i) t[k][i] = t[k - 1][i] >> 8 ^ t[0][t[k - 1][i] & 0xFFU];
  return t;
}
inline constexpr Crc32Tables kCrc32Tables = crc32_tables();

/// Of `bytes`, or continued from the sum of those before.
[[nodiscard]] constexpr std::uint32_t crc32(Bytes bytes, std::uint32_t before = 0) {
  const Crc32Tables& t = kCrc32Tables;
  std::uint32_t sum = ~before;
  std::size_t i = 0;
  for (; i + 8 <= bytes.size(); i += 8) {
    const std::uint32_t low = load_le<std::uint32_t>(&bytes[i]) ^ sum;
    const auto high = load_le<std::uint32_t>(&bytes[i + 4]);
    sum = t[7][low & 0xFFU] ^ t[6][low >> 8 & 0xFFU] ^ t[5][low >> 16 & 0xFFU] ^ t[4][low >> 24] ^
          t[3][high & 0xFFU] ^ t[2][high >> 8 & 0xFFU] ^ t[1][high >> 16 & 0xFFU] ^
          t[0][high >> 24];
  }
  for (; i < bytes.size(); ++i) sum = sum >> 8 ^ t[0][(sum ^ bytes[i]) & 0xFFU];
  return ~sum;
}

}  // namespace wayfare::decode::detail
