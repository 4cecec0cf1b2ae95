#pragma once

// Loads and stores of numbers in either byte order at any alignment.

#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>
#include <type_traits>

namespace wayfare::decode {

using Bytes = std::span<const std::uint8_t>;  ///< that another owns

namespace detail {

template <std::size_t Size>
using UnsignedOf = std::conditional_t<
    Size == 1, std::uint8_t,
    std::conditional_t<Size == 2, std::uint16_t,
                       std::conditional_t<Size == 4, std::uint32_t, std::uint64_t>>>;

}  // namespace detail

template <class T>
concept Number = std::integral<T> || std::floating_point<T>;

/// The number whose least significant byte is at `p`; sizeof(T) bytes are read.
template <Number T>
[[nodiscard]] constexpr T load_le(const std::uint8_t* p) {
  using U = detail::UnsignedOf<sizeof(T)>;
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) bits |= std::uint64_t{p[i]} << (8 * i);
  return std::bit_cast<T>(static_cast<U>(bits));
}

/// The number whose least significant byte is bytes[at].
template <Number T>
[[nodiscard]] T load_le(std::string_view bytes, std::size_t at) {
  return load_le<T>(reinterpret_cast<const std::uint8_t*>(bytes.data()) + at);
}

/// The number whose most significant byte is at `p`; sizeof(T) bytes are read.
template <Number T>
[[nodiscard]] constexpr T load_be(const std::uint8_t* p) {
  using U = detail::UnsignedOf<sizeof(T)>;
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) bits = bits << 8 | p[i];
  return std::bit_cast<T>(static_cast<U>(bits));
}

/// Number of bytes before the first `value`; all of them where there is none.
[[nodiscard]] inline std::size_t bytes_before(Bytes bytes, std::uint8_t value) {
  if (bytes.empty()) return 0;
  const void* found = std::memchr(bytes.data(), value, bytes.size());
  if (found == nullptr) return bytes.size();
  return static_cast<std::size_t>(static_cast<const std::uint8_t*>(found) - bytes.data());
}

/// Writes a number, its least significant byte first.
template <Number T>
constexpr void store_le(T value, std::uint8_t* p) {
  const std::uint64_t bits = std::bit_cast<detail::UnsignedOf<sizeof(T)>>(value);
  for (std::size_t i = 0; i < sizeof(T); ++i) p[i] = static_cast<std::uint8_t>(bits >> (8 * i));
}

/// Writes a number, its most significant byte first.
template <Number T>
constexpr void store_be(T value, std::uint8_t* p) {
  const std::uint64_t bits = std::bit_cast<detail::UnsignedOf<sizeof(T)>>(value);
  for (std::size_t i = 0; i < sizeof(T); ++i)
    p[i] = static_cast<std::uint8_t>(bits >> (8 * (sizeof(T) - 1 - i)));
}

}  // namespace wayfare::decode
