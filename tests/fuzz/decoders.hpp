#pragma once

// Common parts of the decoders' fuzz targets.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <utility>
#include <vector>

#include <wayfare/decode/stream_decoder.hpp>

namespace wayfare::fuzz {

inline void require(bool good) {
  if (!good) std::abort();
}

/// Decodes the bytes in one piece and in pieces whose lengths are taken from the bytes: the results
/// must be equal. Every piece is a separate copy, so that a read past its end is detected. `f` is
/// called with the messages of the first run.
template <class Decoder, class F>
void decode(decode::Bytes bytes, const Decoder& fresh, F&& f) {
  std::vector<std::pair<std::uint64_t, std::size_t>> whole, pieces;
  const auto first = std::make_unique<Decoder>(fresh), second = std::make_unique<Decoder>(fresh);
  const auto use = [&](const auto& m) {
    require(m.position() + m.bytes().size() <= bytes.size());
    require(std::equal(m.bytes().begin(), m.bytes().end(), bytes.begin() + long(m.position())));
    whole.emplace_back(m.position(), m.bytes().size());
    f(m);
  };
  const auto note = [&](const auto& m) { pieces.emplace_back(m.position(), m.bytes().size()); };
  first->feed(bytes, use);
  first->finish(use);
  for (std::size_t at = 0; at < bytes.size();) {
    const std::size_t n = std::min<std::size_t>(bytes.size() - at, 1U + bytes[at] % 61U);
    const std::vector<std::uint8_t> piece(bytes.begin() + long(at), bytes.begin() + long(at + n));
    second->feed(piece, note);
    at += n;
  }
  second->finish(note);
  require(whole == pieces && first->statistics() == second->statistics());
  require(first->statistics().bytes == bytes.size() && first->held() == 0);
  require(first->work().looks <= 2 * bytes.size() + 2);
}

}  // namespace wayfare::fuzz
