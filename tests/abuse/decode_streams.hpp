#pragma once

// Streams of every device for the tests of abuse, built by their layouts.

#include <cstdint>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/detail/bytes.hpp>
#include <wayfare/core/random.hpp>
#include <wayfare/decode/rplidar_decoder.hpp>
#include <wayfare/decode/rplidar_protocol.hpp>
#include <wayfare/decode/stream_decoder.hpp>
#include <wayfare/decode/ti_decoder.hpp>
#include <wayfare/decode/ti_frame.hpp>
#include <wayfare/decode/xbus.hpp>

namespace wayfare::tests {

using Stream = std::vector<std::uint8_t>;

inline void append(Stream& to, const Stream& more) {
  to.insert(to.end(), more.begin(), more.end());
}

// ---- Xsens ----

inline Stream xbus_message(std::uint8_t id, const Stream& data) {
  Stream out(data.size() + 7);
  out.resize(decode::write_xbus(0xFF, static_cast<decode::XbusId>(id), data, out));
  return out;
}

inline Stream xbus_stream(Rng& rng, int messages) {
  Stream stream;
  for (int i = 0; i < messages; ++i) {
    Stream data(rng.below(i % 10 == 9 ? 400 : 60));
    for (auto& byte : data) byte = rng.below(8) == 0 ? 0xFA : static_cast<std::uint8_t>(rng());
    append(stream, xbus_message(0x36, data));
  }
  return stream;
}

// ---- TI mmWave ----

template <class T>
void append_le(Stream& out, T value) {
  out.resize(out.size() + sizeof(T));
  decode::store_le(value, &out[out.size() - sizeof(T)]);
}

/// A frame with one item of points.
inline Stream ti_frame(std::uint32_t version, std::uint32_t platform, std::uint32_t points,
                       const Stream& payload) {
  Stream out(decode::kTiMagic.begin(), decode::kTiMagic.end());
  for (const std::uint32_t word : {version, 0U, platform, 1U, 0U, points, 1U, 0U, 1U,
                                   static_cast<std::uint32_t>(payload.size())})
    append_le(out, word);
  append(out, payload);
  out.resize((out.size() + 31) / 32 * 32, 0x0F);
  decode::store_le(static_cast<std::uint32_t>(out.size()), &out[12]);
  return out;
}

/// Of SDK 3: x, y, z, speed of each point.
inline Stream ti_float_frame(const std::vector<float>& values) {
  Stream payload;
  for (const float value : values) append_le(payload, value);
  return ti_frame(0x03060000, 0xA1843, static_cast<std::uint32_t>(values.size() / 4), payload);
}

/// Of SDK 1 with one point.
inline Stream ti_fixed_frame() {
  Stream payload;
  for (const int word : {1, 9, 12, -3, 99, -512, 1024, 256})
    append_le(payload, static_cast<std::int16_t>(word));
  return ti_frame(0x01020005, 0xA1642, 1, payload);
}

template <class F>
void each_ti_frame(const Stream& bytes, F&& f) {
  const auto decoder = std::make_unique<decode::TiDecoder>();
  decoder->feed(bytes, f);
  decoder->finish(f);
}

inline Stream ti_stream(Rng& rng, int frames) {
  Stream stream;
  for (int i = 0; i < frames; ++i) {
    std::vector<float> values(4 * rng.below(20));
    for (float& value : values) value = static_cast<float>(rng.uniform(-10.0, 10.0));
    append(stream, i % 3 == 2 ? ti_fixed_frame() : ti_float_frame(values));
  }
  return stream;
}

// ---- RPLIDAR ----

inline Stream rplidar_descriptor_of(decode::RplidarResponse response, std::uint32_t length,
                                    bool endless) {
  Stream out = {0xA5, 0x5A, 0, 0, 0, 0, static_cast<std::uint8_t>(response)};
  decode::store_le(length | (endless ? 1U << 30 : 0U), &out[2]);
  return out;
}

inline Stream rplidar_node_of(int angle_q6, int distance_q2, bool start = false) {
  return {static_cast<std::uint8_t>(15 << 2 | (start ? 1 : 2)),
          static_cast<std::uint8_t>((angle_q6 & 0x7F) << 1 | 1),
          static_cast<std::uint8_t>(angle_q6 >> 7), static_cast<std::uint8_t>(distance_q2),
          static_cast<std::uint8_t>(distance_q2 >> 8)};
}

/// Head and checksum around a capsule's contents; the start takes 15 bits.
inline Stream rplidar_capsule(int start_q6, const Stream& contents) {
  Stream out = {0, 0, static_cast<std::uint8_t>(start_q6),
                static_cast<std::uint8_t>(start_q6 >> 8)};
  append(out, contents);
  unsigned sum = 0;
  for (const std::uint8_t byte : out) sum ^= byte;
  out[0] = static_cast<std::uint8_t>(0xA0 | (sum & 0xF));
  out[1] = static_cast<std::uint8_t>(0x50 | sum >> 4);
  return out;
}

/// Replies, nodes and capsules, one after the other as a host requests them.
inline Stream rplidar_stream(Rng& rng, int parts) {
  using enum decode::RplidarResponse;
  Stream stream;
  for (int part = 0; part < parts; ++part) {
    switch (part % 4) {
      case 0:
        append(stream, rplidar_descriptor_of(health, 3, false));
        append(stream, {0, 0, 0});
        break;
      case 1:
        append(stream, rplidar_descriptor_of(node, 5, true));
        for (int i = 0; i < 60; ++i)
          append(stream, rplidar_node_of(i * 384, static_cast<int>(rng.below(20000)), i == 0));
        break;
      default: {
        const bool large = part % 4 == 3;
        append(stream, rplidar_descriptor_of(large ? ultra : express, large ? 132 : 84, true));
        for (int i = 0; i < 4; ++i) {
          Stream contents(large ? 128 : 80);
          for (auto& byte : contents) byte = static_cast<std::uint8_t>(rng());
          append(stream, rplidar_capsule(i * 2000, contents));
        }
      }
    }
  }
  return stream;
}

// ---- all of them ----

/// A decoder and a stream that it decodes.
template <class Decoder>
struct DeviceStream {
  const char* name;
  Stream stream;

  [[nodiscard]] std::unique_ptr<Decoder> fresh() const { return std::make_unique<Decoder>(); }
};

/// Calls `f(device)` with each device in turn.
template <class F>
void for_every_decoder(const F& f, std::uint64_t seed = 1) {
  Rng rng(seed);
  const auto with = [&](const auto& device) {
    SCOPED_TRACE(device.name);
    f(device);
  };
  with(DeviceStream<decode::TiDecoder>{"TI mmWave", ti_stream(rng, 12)});
  with(DeviceStream<decode::XbusDecoder>{"Xsens", xbus_stream(rng, 40)});
  with(DeviceStream<decode::StreamDecoder<decode::BasicXbusFraming<32>>>{"Xsens, short",
                                                                         xbus_stream(rng, 40)});
  with(DeviceStream<decode::RplidarDecoder>{"RPLIDAR", rplidar_stream(rng, 12)});
}

/// A message as text: where it was and its bytes.
template <class Message>
std::string seen_text(const Message& m, std::uint64_t origin = 0) {
  std::string text = std::to_string(m.position() - origin) + ":";
  text.append(reinterpret_cast<const char*>(m.bytes().data()), m.bytes().size());
  return text;
}

}  // namespace wayfare::tests
