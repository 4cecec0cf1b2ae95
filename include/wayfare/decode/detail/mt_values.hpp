#pragma once

// The packets inside an Xsens MTData2 message, and the four encodings of their numbers.

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>

#include <wayfare/core/detail/bytes.hpp>

namespace wayfare::decode {

/// Encoding of numbers: the lowest two bits of a packet's id.
enum class MtPrecision : std::uint8_t {
  float32 = 0,
  fixed_12_20 = 1,
  fixed_16_32 = 2,
  float64 = 3
};

[[nodiscard]] constexpr std::size_t bytes_of(MtPrecision precision) {
  constexpr std::array<std::size_t, 4> kBytes = {4, 4, 6, 8};
  return kBytes[static_cast<std::size_t>(precision)];
}

/// One number. The 48 bits of 16.32 are the fraction, then the whole part.
[[nodiscard]] inline double mt_real(const std::uint8_t* p, MtPrecision precision) {
  switch (precision) {
    case MtPrecision::float32:
      return static_cast<double>(load_be<float>(p));
    case MtPrecision::fixed_12_20:
      return load_be<std::int32_t>(p) * 0x1p-20;
    case MtPrecision::fixed_16_32:
      return load_be<std::int16_t>(p + 4) + load_be<std::uint32_t>(p) * 0x1p-32;
    default:
      return load_be<double>(p);
  }
}

/// A packet: id and data.
struct MtPacket {
  std::uint16_t id = 0;
  Bytes data;

  [[nodiscard]] std::uint16_t kind() const { return static_cast<std::uint16_t>(id & 0xFFF0); }
  [[nodiscard]] MtPrecision precision() const { return static_cast<MtPrecision>(id & 3); }

  /// `N` numbers; nullopt where the packet has a different length or one is not finite.
  template <std::size_t N>
  [[nodiscard]] std::optional<std::array<double, N>> reals() const {
    const std::size_t size = bytes_of(precision());
    if (data.size() != N * size) return std::nullopt;
    std::array<double, N> values{};
    for (std::size_t i = 0; i < N; ++i) {
      values[i] = mt_real(&data[i * size], precision());
      if (!std::isfinite(values[i])) return std::nullopt;
    }
    return values;
  }
  /// A whole number that is the packet's only content.
  template <class T>
  [[nodiscard]] std::optional<T> whole() const {
    if (data.size() != sizeof(T)) return std::nullopt;
    return load_be<T>(data.data());
  }
};

/// Calls `f(const MtPacket&)` for the packets of an MTData2 message in order; false where the last
/// one is longer than the message.
template <class F>
bool for_each_mt_packet(Bytes data, F&& f) {
  while (!data.empty()) {
    if (data.size() < 3 || data.size() - 3 < data[2]) return false;
    f(MtPacket{load_be<std::uint16_t>(data.data()), data.subspan(3, data[2])});
    data = data.subspan(3U + data[2]);
  }
  return true;
}

}  // namespace wayfare::decode
