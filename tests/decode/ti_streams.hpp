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

/// Items behind a head of `out` so far, whose length is at byte `total_at`; `counted`: bytes by
/// which the length of an item exceeds its payload.
inline Stream with_items(Stream out, const std::vector<Item>& items, std::size_t total_at,
                         std::uint32_t counted) {
  for (const Item& item : items) {
    append(out, item.type);
    append(out, static_cast<std::uint32_t>(item.payload.size()) + counted);
    out.insert(out.end(), item.payload.begin(), item.payload.end());
  }
  out.resize((out.size() + 31) / 32 * 32);
  store_le(static_cast<std::uint32_t>(out.size()), &out[total_at]);
  return out;
}

/// A frame of the area scanner: the demo's header and the number of static points.
inline Stream area_frame(std::uint32_t number, std::uint32_t points, std::uint32_t static_points,
                         const std::vector<Item>& items) {
  Stream out(kTiMagic.begin(), kTiMagic.end());
  for (const std::uint32_t word : {0x03040001U, 0U, 0xA6843U, number, 7000U, points,
                                   static_cast<std::uint32_t>(items.size()), 2U, static_points})
    append(out, word);
  return with_items(out, items, 12, 0);
}

/// The complement of the sum of a header's 16-bit words, the carry added.
inline void seal_header(Stream& frame, std::size_t bytes) {
  std::uint32_t sum = 0;
  store_le(std::uint16_t{0}, &frame[bytes - 2]);
  for (std::size_t i = 0; i < bytes; i += 2) sum += load_le<std::uint16_t>(&frame[i]);
  store_le(static_cast<std::uint16_t>(~((sum >> 16) + (sum & 0xFFFF))), &frame[bytes - 2]);
}

/// A frame of 3D people counting: times of processing instead of a clock, then number and checksum.
inline Stream tracker_3d_frame(std::uint32_t number, const std::vector<Item>& items,
                               std::uint32_t frame_us = 2500) {
  Stream out(kTiMagic.begin(), kTiMagic.end());
  for (const std::uint32_t word : {0x03020004U, 0U, 0xA6843U, number, 0U, 11U, frame_us, 900U, 4U})
    append(out, word);
  append(out, static_cast<std::uint16_t>(items.size()));
  append(out, std::uint16_t{0});
  out = with_items(out, items, 12, 8);
  seal_header(out, 48);
  return out;
}

/// A frame of people counting in a plane: its length is the fourth word.
inline Stream tracker_2d_frame(std::uint32_t number, const std::vector<Item>& items) {
  Stream out(kTiMagic.begin(), kTiMagic.end());
  for (const std::uint32_t word :
       {0x01020003U, 0xA1642U, 60'000'000U * number, 0U, number, 0U, 11U, 12U, 13U, 14U})
    append(out, word);
  append(out, static_cast<std::uint16_t>(items.size()));
  append(out, std::uint16_t{0});
  out = with_items(out, items, 20, 8);
  seal_header(out, 52);
  return out;
}

template <class T>
Item item_of(std::uint32_t type, const std::vector<T>& values) {
  Item item{type, {}};
  for (const T& value : values) append(item.payload, value);
  return item;
}

/// A point in numbers of the units.
struct CompressedPoint {
  int elevation = 0, azimuth = 0, doppler = 0, range = 0, snr = 0;
};

/// Points behind their units of elevation, azimuth, speed, range, strength.
inline Item compressed_points(std::uint32_t type, const std::vector<CompressedPoint>& points) {
  Item item = item_of<float>(type, {0.01F, 0.02F, 0.1F, 0.00025F, 0.04F});
  for (const CompressedPoint& p : points) {
    append(item.payload, static_cast<std::int8_t>(p.elevation));
    append(item.payload, static_cast<std::int8_t>(p.azimuth));
    append(item.payload, static_cast<std::int16_t>(p.doppler));
    append(item.payload, static_cast<std::uint16_t>(p.range));
    append(item.payload, static_cast<std::uint16_t>(p.snr));
  }
  return item;
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
