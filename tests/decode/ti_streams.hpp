#pragma once

// Frames of TI's demo built by its layout, and their decoded messages.

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <wayfare/decode/ti_decoder.hpp>
#include <wayfare/decode/ti_frame.hpp>

#include "captures.hpp"

namespace wayfare::decode {

template <class T>
void append(Stream& out, T value) {
  out.resize(out.size() + sizeof(T));
  store_le(value, &out[out.size() - sizeof(T)]);
}

struct Item {
  std::uint32_t type = 0;
  Stream payload;
};

/// A frame built by the layout, with the header of 36 or 40 bytes of its version and platform.
inline Stream frame(std::uint32_t number, std::uint32_t points, const std::vector<Item>& items,
                    std::uint32_t version = 0x03060000, std::uint32_t platform = 0xA1843) {
  const TiHeader header{version, 0, platform, number, 0, points, 0, 0};
  Stream out(kTiMagic.begin(), kTiMagic.end());
  for (const std::uint32_t word : {version, 0U, platform, number, number * 20'000'000U, points,
                                   static_cast<std::uint32_t>(items.size())})
    append(out, word);
  if (header.bytes() == 40) append(out, 0U);
  for (const Item& item : items) {
    append(out, item.type);
    append(out, static_cast<std::uint32_t>(item.payload.size()));
    out.insert(out.end(), item.payload.begin(), item.payload.end());
  }
  out.resize((out.size() + 31) / 32 * 32, 0x0F);
  store_le(static_cast<std::uint32_t>(out.size()), &out[12]);
  return out;
}

inline Item float_points(int n) {
  Item item{1, {}};
  for (int i = 0; i < 4 * n; ++i) append(item.payload, 0.5F * static_cast<float>(i));
  return item;
}

inline Item side_info(int n) {
  Item item{7, {}};
  for (int i = 0; i < 2 * n; ++i) append(item.payload, static_cast<std::int16_t>(100 + i));
  return item;
}

inline Stream joined(const std::vector<Stream>& parts) {
  Stream all;
  for (const Stream& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

inline std::string text_of(const TiFrame& f) {
  return std::to_string(f.header().frame_number) + ":" + testing::fingerprint(f.bytes());
}

template <class F>
DecoderStatistics each_frame(const Stream& bytes, F&& f) {
  const auto decoder = std::make_unique<TiDecoder>();
  decoder->feed(bytes, f);
  decoder->finish(f);
  return decoder->statistics();
}

inline std::vector<std::uint32_t> numbers(const Stream& bytes) {
  std::vector<std::uint32_t> result;
  each_frame(bytes, [&](const TiFrame& f) { result.push_back(f.header().frame_number); });
  return result;
}

}  // namespace wayfare::decode
