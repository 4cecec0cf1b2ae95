#pragma once

// Xbus messages built by the manual, and their decoded messages.

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <wayfare/decode/xbus.hpp>

#include "captures.hpp"

namespace wayfare::decode {

inline Stream message(XbusId id, const Stream& data, std::uint8_t bus = 0xFF) {
  Stream out(data.size() + 7);
  out.resize(write_xbus(bus, id, data, out));
  return out;
}

template <class T>
void put(Stream& out, T value) {
  out.resize(out.size() + sizeof(T));
  store_be(value, &out[out.size() - sizeof(T)]);
}

inline std::string text_of(const XbusMessage& m) {
  return std::to_string(static_cast<int>(m.id())) + ":" + testing::fingerprint(m.bytes());
}

template <class F>
DecoderStatistics each_message(const Stream& bytes, F&& f) {
  const auto decoder = std::make_unique<XbusDecoder>();
  decoder->feed(bytes, f);
  decoder->finish(f);
  return decoder->statistics();
}

}  // namespace wayfare::decode
