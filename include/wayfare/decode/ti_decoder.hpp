#pragma once

// Frames from the data port of a TI mmWave sensor. The format has no checksum: a frame is accepted
// where its magic word, lengths, counts and end are consistent.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include <wayfare/core/detail/bytes.hpp>
#include <wayfare/decode/stream_decoder.hpp>
#include <wayfare/decode/ti_frame.hpp>

namespace wayfare::decode {

inline constexpr std::array<std::uint8_t, 8> kTiMagic = {2, 1, 4, 3, 6, 5, 8, 7};

/// The first magic word at or after `from`, or `bytes.size()`. Its eight bytes are all different,
/// so that one byte determines the shift (Horspool 1980) and no byte is examined more than twice.
[[nodiscard]] inline std::size_t find_ti_magic(Bytes bytes, std::size_t from) {
  // Distance from byte value v in the word to its end; 8 where it is not part of the word.
  constexpr std::array<std::uint8_t, 9> kShift = {8, 6, 7, 4, 5, 2, 3, 8, 1};
  const std::uint64_t word = load_le<std::uint64_t>(kTiMagic.data());
  std::size_t at = from;
  while (at + 8 <= bytes.size()) {
    const std::uint8_t last = bytes[at + 7];
    if (last > 8) {
      at += 8;
    } else if (last != 7) {
      at += kShift[last];
    } else if (load_le<std::uint64_t>(&bytes[at]) == word) {
      return at;
    } else {
      at += 8;
    }
  }
  return bytes.size();
}

/// Framing of the data port. A frame ends where its header says, or at the next magic word where
/// that comes first (cut frames, and demos whose header counts too many bytes).
class TiFraming {
 public:
  using Message = TiFrame;
  static constexpr std::size_t kCapacity = std::size_t{1} << 16;  ///< longest frame

  Look look(const Front& front, DecoderStatistics& statistics) {
    const Bytes b = front.bytes;
    if (front.position != start_) {
      start_ = front.position;
      scanned_ = 8;
    }
    const std::size_t magic = find_ti_magic(b.first(std::min<std::size_t>(b.size(), 8)), 0);
    if (magic != 0 || b.size() < 8) return seek(b);
    if (b.size() < kLeastHeader) return Look::need(kLeastHeader);
    const TiHeader header = read_header(b);
    if (!plausible(header)) {
      ++statistics.malformed;
      return Look::skip(8);
    }
    const std::size_t total = header.total_bytes, seen = std::min(b.size(), total);
    const std::size_t next = find_ti_magic(b.first(seen), scanned_);
    examined_ += next - scanned_;
    if (next == seen && seen < total) {
      scanned_ = std::max(scanned_, seen - 7);
      return Look::need(std::min(total, seen + kRescanStep));
    }
    return close(b.first(next), header, statistics);
  }

  template <class Sink>
  void deliver(Bytes bytes, std::uint64_t position, Sink& sink) {
    frame_.position_ = position;
    frame_.bytes_ = bytes;
    sink(static_cast<const TiFrame&>(frame_));
  }

  [[nodiscard]] std::uint64_t examined() const { return examined_; }

 private:
  static constexpr std::size_t kLeastHeader = 36;
  static constexpr std::size_t kRescanStep = 256;  ///< bytes between searches for an early end

  /// No frame begins here: skips to the next magic word, or to what may be its beginning.
  Look seek(Bytes b) {
    const std::size_t magic = find_ti_magic(b, 0);
    examined_ += magic;
    if (magic < b.size()) return Look::skip(magic);
    return b.size() > 7 ? Look::skip(b.size() - 7) : Look::need(b.size() + 1);
  }

  static TiHeader read_header(Bytes b) {
    const auto word = [&](std::size_t at) { return load_le<std::uint32_t>(&b[at]); };
    return {word(8), word(12), word(16), word(20), word(24), word(28), word(32), 0};
  }

  static bool plausible(const TiHeader& h) {
    return h.total_bytes >= h.bytes() && h.total_bytes <= kCapacity &&
           h.tlvs <= h.total_bytes / 8 && h.points <= h.total_bytes / 12;
  }

  /// `b` is the whole frame. The search resumes in the last bytes of the items and the padding:
  /// where bytes of the frame were lost, the next magic word begins there.
  Look close(Bytes b, const TiHeader& header, DecoderStatistics& statistics) {
    const std::size_t used = parse(b, header);
    examined_ += b.size();
    if (used == 0) {
      ++statistics.malformed;
      return Look::skip(std::max<std::size_t>(8, b.size() - 7));
    }
    return {Look::Kind::frame, b.size(), std::max<std::size_t>(8, used - 7)};
  }

  /// Bytes used by header and items, 0 where the frame is inconsistent. Frames are padded to a
  /// multiple of 32 bytes.
  std::size_t parse(Bytes b, const TiHeader& header) {
    frame_ = {};
    frame_.header_ = header;
    std::size_t at = header.bytes();
    if (b.size() < at) return 0;
    if (at == 40) frame_.header_.subframe = load_le<std::uint32_t>(&b[36]);
    frame_.items_ = b.subspan(at);
    for (std::uint32_t i = 0; i < header.tlvs; ++i) {
      if (b.size() - at < 8) return 0;
      const std::size_t length = load_le<std::uint32_t>(&b[at + 4]);
      if (length > b.size() - at - 8) return 0;
      if (!take(load_le<std::uint32_t>(&b[at]), b.subspan(at + 8, length))) return 0;
      at += 8 + length;
    }
    if (frame_.points_ != header.points || b.size() - at >= 32) return 0;
    const bool side = frame_.side_info_.empty() || frame_.side_info_.size() == 4 * frame_.points_;
    return side ? at : 0;
  }

  bool take(std::uint32_t type, Bytes payload) {
    if (type == static_cast<std::uint32_t>(TiTlv::points)) return take_points(payload);
    if (type == static_cast<std::uint32_t>(TiTlv::side_info)) frame_.side_info_ = payload;
    return true;
  }

  bool take_points(Bytes payload) {
    if (frame_.header_.major() >= 3) {
      if (payload.size() % 16 != 0) return false;
      frame_.points_ = payload.size() / 16;
      frame_.coordinates_ = payload;
      return true;
    }
    if (payload.size() < 4) return false;
    frame_.points_ = load_le<std::uint16_t>(payload.data());
    const unsigned q = load_le<std::uint16_t>(&payload[2]);
    frame_.coordinates_ = payload.subspan(4);
    if (q > 15 || frame_.coordinates_.size() != 12 * frame_.points_) return false;
    frame_.fixed_point_scale_ = 1.0F / static_cast<float>(1U << q);
    return true;
  }

  TiFrame frame_;
  std::uint64_t examined_ = 0;
  std::uint64_t start_ = 0;  ///< of the candidate frame
  std::size_t scanned_ = 8;  ///< up to here it contains no other magic word
};

using TiDecoder = StreamDecoder<TiFraming>;

}  // namespace wayfare::decode
