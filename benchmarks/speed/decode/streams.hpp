#pragma once

// Byte streams of the devices, for the decoders.

#include <cstdint>
#include <vector>

#include <wayfare/core/random.hpp>
#include <wayfare/decode/detail/crc32.hpp>
#include <wayfare/decode/ti_decoder.hpp>
#include <wayfare/decode/xbus.hpp>

namespace wayfare::decode {

using Stream = std::vector<std::uint8_t>;

template <class T>
void put_le(Stream& out, T value) {
  std::uint8_t bytes[sizeof(T)];
  store_le(value, bytes);
  for (const std::uint8_t byte : bytes) out.push_back(byte);
}
template <class T>
void put_be(Stream& out, T value) {
  std::uint8_t bytes[sizeof(T)];
  store_be(value, bytes);
  for (const std::uint8_t byte : bytes) out.push_back(byte);
}

/// Frames as an AWR1843 sends them: 150 points with side information, range profile, statistics.
inline Stream ti_stream() {
  Rng rng(1);
  Stream out;
  for (std::uint32_t i = 1; i <= 300; ++i) {
    const std::size_t start = out.size();
    out.insert(out.end(), kTiMagic.begin(), kTiMagic.end());
    for (const std::uint32_t word : {0x03060000U, 0U, 0xA1843U, i, 20'000'000 * i, 150U, 4U, 0U})
      put_le(out, word);
    put_le(out, 1U);
    put_le(out, 150U * 16U);
    for (int k = 0; k < 600; ++k) put_le(out, static_cast<float>(rng.uniform(-8.0, 8.0)));
    put_le(out, 7U);
    put_le(out, 150U * 4U);
    for (int k = 0; k < 300; ++k) put_le(out, static_cast<std::int16_t>(rng.below(800)));
    put_le(out, 2U);
    put_le(out, 512U);
    for (int k = 0; k < 256; ++k) put_le(out, static_cast<std::uint16_t>(rng.below(12000)));
    put_le(out, 6U);
    put_le(out, 24U);
    for (int k = 0; k < 6; ++k) put_le(out, static_cast<std::uint32_t>(rng.below(50000)));
    while ((out.size() - start) % 32 != 0) out.push_back(15);
    store_le(static_cast<std::uint32_t>(out.size() - start), &out[start + 12]);
  }
  return out;
}

/// Frames of 3D people counting, 150 compressed points each, behind the demo's header or, with
/// `checked`, behind one of 48 bytes with a checksum.
inline Stream people_stream(bool checked) {
  Rng rng(6);
  Stream out;
  for (std::uint32_t i = 1; i <= 300; ++i) {
    const std::size_t start = out.size();
    out.insert(out.end(), kTiMagic.begin(), kTiMagic.end());
    if (checked) {
      for (const std::uint32_t word : {0x03020004U, 0U, 0xA6843U, i, 0U, 11U, 2500U, 900U, 4U, 1U})
        put_le(out, word);
    } else {
      for (const std::uint32_t word : {0x03060000U, 0U, 0xA6843U, i, 20'000'000 * i, 150U, 1U, 0U})
        put_le(out, word);
    }
    const std::uint32_t length = 20 + 150 * 8;
    put_le(out, checked ? 6U : 1020U);
    put_le(out, checked ? length + 8 : length);
    for (const float unit : {0.01F, 0.01F, 0.05F, 0.00025F, 0.04F}) put_le(out, unit);
    for (int k = 0; k < 150 * 4; ++k) put_le(out, static_cast<std::uint16_t>(rng.below(60'000)));
    while ((out.size() - start) % 32 != 0) out.push_back(15);
    store_le(static_cast<std::uint32_t>(out.size() - start), &out[start + 12]);
    if (!checked) continue;
    std::uint32_t sum = 0;
    for (std::size_t k = 0; k < 46; k += 2) sum += load_le<std::uint16_t>(&out[start + k]);
    store_le(static_cast<std::uint16_t>(~((sum >> 16) + (sum & 0xFFFF))), &out[start + 46]);
  }
  return out;
}

/// Messages of an MTi at 100 Hz: counter, time, acceleration, rate, field, quaternion, status.
inline Stream xbus_stream() {
  Rng rng(2);
  Stream out;
  for (std::uint32_t i = 0; i < 10'000; ++i) {
    Stream data;
    const auto vector = [&](std::uint16_t id, int n) {
      put_be(data, id);
      data.push_back(static_cast<std::uint8_t>(4 * n));
      for (int k = 0; k < n; ++k) put_be(data, static_cast<float>(rng.uniform(-10.0, 10.0)));
    };
    put_be(data, std::uint16_t{0x1020});
    data.push_back(2);
    put_be(data, static_cast<std::uint16_t>(i));
    put_be(data, std::uint16_t{0x1060});
    data.push_back(4);
    put_be(data, 100 * i);
    vector(0x2010, 4);
    vector(0x4020, 3);
    vector(0x8020, 3);
    vector(0xC020, 3);
    put_be(data, std::uint16_t{0xE020});
    data.push_back(4);
    put_be(data, 7U);
    Stream message(data.size() + 7);
    message.resize(write_xbus(0xFF, XbusId::mt_data2, data, message));
    out.insert(out.end(), message.begin(), message.end());
  }
  return out;
}

inline Stream node_stream() {
  Rng rng(3);
  Stream out;
  for (unsigned i = 0; i < 200'000; ++i) {
    const unsigned angle = i * 76 % (360 * 64);
    out.push_back(static_cast<std::uint8_t>(15 << 2 | (angle < 76 ? 1 : 2)));
    out.push_back(static_cast<std::uint8_t>((angle & 0x7F) << 1 | 1));
    out.push_back(static_cast<std::uint8_t>(angle >> 7));
    put_le(out, static_cast<std::uint16_t>(rng.below(40000)));
  }
  return out;
}

/// `angle_at`: where a capsule has its angle.
inline Stream capsule_stream(std::size_t contents, std::size_t angle_at = 2) {
  Rng rng(4);
  Stream out;
  for (unsigned i = 0; i < 5000; ++i) {
    Stream capsule(4 + contents);
    for (auto& byte : capsule) byte = static_cast<std::uint8_t>(rng());
    store_le(static_cast<std::uint16_t>(i * 640 % (360 * 64)), &capsule[angle_at]);
    unsigned sum = 0;
    for (std::size_t k = 2; k < capsule.size(); ++k) sum ^= capsule[k];
    capsule[0] = static_cast<std::uint8_t>(0xA0 | (sum & 15));
    capsule[1] = static_cast<std::uint8_t>(0x50 | sum >> 4);
    out.insert(out.end(), capsule.begin(), capsule.end());
  }
  return out;
}

inline Stream ultra_dense_stream() { return capsule_stream(166, 8); }

inline Stream hq_stream() {
  Rng rng(8);
  Stream out;
  for (unsigned i = 0; i < 1000; ++i) {
    Stream capsule(777);
    for (auto& byte : capsule) byte = static_cast<std::uint8_t>(rng());
    capsule[0] = 0xA5;
    capsule.resize(780, 0);
    const std::uint32_t sum = wayfare::decode::detail::crc32(capsule);
    capsule.resize(781);
    store_le(sum, &capsule[777]);
    out.insert(out.end(), capsule.begin(), capsule.end());
  }
  return out;
}

/// Raw readings and temperatures of an MTi.
inline Stream raw_stream() {
  Rng rng(9);
  Stream out;
  for (std::uint32_t i = 0; i < 10'000; ++i) {
    Stream data = {0xA0, 0x10, 20};
    for (int k = 0; k < 10; ++k) put_be(data, static_cast<std::uint16_t>(rng.below(65'536)));
    data.insert(data.end(), {0xA0, 0x20, 6, 1, 2, 3, 4, 5, 6});
    Stream message(data.size() + 7);
    message.resize(write_xbus(0xFF, XbusId::mt_data2, data, message));
    out.insert(out.end(), message.begin(), message.end());
  }
  return out;
}

}  // namespace wayfare::decode
