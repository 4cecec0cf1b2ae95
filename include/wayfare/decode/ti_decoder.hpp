#pragma once

// Frames from the data port of a TI mmWave sensor. The format has no checksum: a frame is accepted
// where its magic word, lengths, counts and end are consistent.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include <wayfare/core/detail/bytes.hpp>
#include <wayfare/decode/stream_decoder.hpp>
#include <wayfare/decode/ti_config.hpp>
#include <wayfare/decode/ti_frame.hpp>
#include <wayfare/decode/ti_refusal.hpp>

namespace wayfare::decode {

/// Before every frame.
inline constexpr std::array<std::uint8_t, 8> kTiMagic = {2, 1, 4, 3, 6, 5, 8, 7};

/// The first magic word at or after `from`, or `bytes.size()`. Its eight bytes are all different,
/// so that one byte determines the shift (Horspool 1980) and no byte is examined more than twice.
[[nodiscard]] inline std::size_t find_ti_magic(Bytes bytes, std::size_t from) {
  // Distance from byte value v in the word to its end; 8 where it is not part of the word.
  constexpr std::array<std::uint8_t, 9> kShift = {8, 6, 7, 4, 5, 2, 3, 8, 1};
  const auto word = load_le<std::uint64_t>(kTiMagic.data());
  if (bytes.size() < 8) return bytes.size();
  const std::size_t last_start = bytes.size() - 8;
  std::size_t at = from;
  while (at <= last_start) {
    const std::uint8_t last = bytes[at + 7];
    if (last == 7 && load_le<std::uint64_t>(&bytes[at]) == word) return at;
    at += last < kShift.size() ? kShift[last] : 8;
  }
  return bytes.size();
}

/// Framing of the data port. A frame ends where its header says, or at the next magic word where
/// that comes first (cut frames, and demos whose header counts too many bytes). The header is taken
/// for the demo's; where that is not consistent, for one with a checksum that is right, or an area
/// scanner's.
class TiFraming {
 public:
  using Message = TiFrame;                                        ///< of the sensor's data port
  static constexpr std::size_t kCapacity = std::size_t{1} << 16;  ///< longest frame

  /// What begins at the front of the stream.
  Look look(const Front& front, DecoderStatistics& statistics) {
    const Bytes b = front.bytes;
    if (front.position != start_) {
      start_ = front.position;
      scanned_ = 8;
    }
    const std::size_t magic = find_ti_magic(b.first(std::min<std::size_t>(b.size(), 8)), 0);
    if (magic != 0 || b.size() < 8) return seek(b);
    if (b.size() < kLeastHeader) return Look::need(kLeastHeader);
    TiHeader header = read_header(b);
    if (!plausible(header)) {
      if (b.size() < kMostHeader && !front.ended) return Look::need(kMostHeader);
      const auto checked = checked_header(b);
      if (!checked) return refuse(front.position, header, TiFault::header, 8, statistics);
      header = *checked;
    }
    const std::size_t total = header.total_bytes, seen = std::min(b.size(), total);
    const std::size_t next = find_ti_magic(b.first(seen), scanned_);
    examined_ += next - scanned_;
    if (next == seen && seen < total) {
      scanned_ = std::max(scanned_, seen - 7);
      return Look::need(std::min(total, seen + kRescanStep));
    }
    return close(b.first(next), header, front.position, statistics);
  }

  /// Passes the frame to `sink(const TiFrame&)`.
  template <class Sink>
  void deliver(Bytes bytes, std::uint64_t position, Sink& sink) {
    frame_.position_ = position;
    frame_.bytes_ = bytes;
    sink(static_cast<const TiFrame&>(frame_));
  }

  /// Number of bytes inspected so far.
  [[nodiscard]] std::uint64_t examined() const { return examined_; }
  /// The last magic word that no frame begins with; its fault is `none` while there is none.
  [[nodiscard]] const TiRefusal& refusal() const { return refusal_; }

 private:
  static constexpr std::size_t kLeastHeader = 36, kMostHeader = 52;
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

  /// A header of 48 or 52 bytes whose words of 16 bits add up to all ones, the carry added.
  static std::optional<TiHeader> checked_header(Bytes b) {
    const auto word = [&](std::size_t at) { return load_le<std::uint32_t>(&b[at]); };
    const auto matches = [&](std::size_t bytes) {
      std::uint32_t sum = 0;
      for (std::size_t i = 0; i < bytes && bytes <= b.size(); i += 2)
        sum += load_le<std::uint16_t>(&b[i]);
      return (sum >> 16) + (sum & 0xFFFFU) == 0xFFFFU;
    };
    TiHeader header;
    if (matches(48)) {
      header = {word(8), word(12), word(16), word(20), 0, 0, load_le<std::uint16_t>(&b[44]),
                word(24)};
      header.layout = TiLayout::tracker_3d;
    } else if (matches(52)) {
      header = {word(8), word(20), word(12), word(24), word(16), 0, load_le<std::uint16_t>(&b[48]),
                word(28)};
      header.layout = TiLayout::tracker_2d;
    }
    const bool found = header.layout != TiLayout::demo && plausible(header);
    return found ? std::optional(header) : std::nullopt;
  }

  static bool plausible(const TiHeader& h) {
    return h.total_bytes >= h.bytes() && h.total_bytes <= kCapacity &&
           h.tlvs <= h.total_bytes / 8 && h.points <= h.total_bytes / 8;
  }

  Look refuse(std::uint64_t position, const TiHeader& header, TiFault fault, std::size_t skip,
              DecoderStatistics& statistics) {
    ++statistics.malformed;
    refusal_ = {position, header, fault, type_};
    return Look::skip(skip);
  }

  /// `b` is the whole frame. The search resumes in the last bytes of the items and the padding:
  /// where bytes of the frame were lost, the next magic word begins there.
  Look close(Bytes b, TiHeader header, std::uint64_t position, DecoderStatistics& statistics) {
    std::size_t used = parse(b, header);
    examined_ += b.size();
    if (used == 0 && header.layout == TiLayout::demo) used = parse_otherwise(b, header);
    if (used == 0)
      return refuse(position, header, fault_, std::max<std::size_t>(8, b.size() - 7), statistics);
    return {Look::Kind::frame, b.size(), std::max<std::size_t>(8, used - 7)};
  }

  /// As parse(), of a frame whose header is not the demo's; `header` becomes the one it has.
  std::size_t parse_otherwise(Bytes b, TiHeader& header) {
    if (b.size() < kMostHeader || header.major() < 3) return 0;
    examined_ += b.size();
    const TiFault fault = fault_;
    const std::uint32_t type = type_;
    if (const auto checked = checked_header(b)) return parse(b, header = *checked);
    TiHeader area = header;
    area.layout = TiLayout::area_scanner;
    const std::size_t used = parse(b, area);
    if (used != 0) {
      header = area;
    } else {  // what is reported is the demo's header
      fault_ = fault;
      type_ = type;
    }
    return used;
  }

  /// Bytes used by header and items, 0 where the frame is inconsistent. Frames are padded to a
  /// multiple of 32 bytes.
  std::size_t parse(Bytes b, const TiHeader& header) {
    frame_ = {};
    frame_.header_ = header;
    type_ = damaged_ = 0;
    fault_ = TiFault::length;
    lab_items_ = demo_points_ = false;
    const std::size_t head = header.bytes();
    if (b.size() < head) return 0;
    if (head == 40 || head == 44) frame_.header_.subframe = load_le<std::uint32_t>(&b[36]);
    if (head == 44) frame_.header_.static_points = load_le<std::uint32_t>(&b[40]);
    frame_.items_ = b.subspan(head);
    const std::size_t used = take_items(b, head, header.counts_item_heads() ? 8 : 0);
    return used != 0 && b.size() - used < 32 && counts_match(header) ? used : 0;
  }

  /// The items from byte `at` on, whose lengths count `counted` bytes too many; where they end, 0
  /// where one is inconsistent.
  std::size_t take_items(Bytes b, std::size_t at, std::size_t counted) {
    for (std::uint32_t i = 0; i < frame_.header_.tlvs; ++i) {
      if (b.size() - at < 8) return 0;
      type_ = load_le<std::uint32_t>(&b[at]);
      const std::size_t length = load_le<std::uint32_t>(&b[at + 4]);
      if (length < counted || length - counted > b.size() - at - 8) return 0;
      if (!take(b.subspan(at + 8, length - counted))) {
        fault_ = TiFault::item;
        return 0;
      }
      at += 8 + length - counted;
    }
    return at;
  }

  /// With items of its laboratories TI counts points differently.
  bool counts_match(const TiHeader& header) {
    if (damaged_ != 0 && !demo_points_) {
      fault_ = TiFault::item;
      type_ = damaged_;
      return false;
    }
    fault_ = TiFault::points;
    if (header.counts_item_heads()) {
      frame_.header_.points = static_cast<std::uint32_t>(frame_.points_);
    } else if ((demo_points_ || !lab_items_) && frame_.points_ != header.points) {
      return false;
    }
    return frame_.side_info_.empty() || frame_.side_info_.size() == 4 * frame_.points_;
  }

  /// The item of type_.
  bool take(Bytes payload) {
    const bool area = frame_.header_.layout == TiLayout::area_scanner;
    if (frame_.header_.counts_item_heads()) {
      constexpr std::uint32_t kPointCloud = 6;
      if (type_ != kPointCloud) return true;
      return frame_.header_.layout == TiLayout::tracker_3d
                 ? take_in_units(payload, TiPoints::compressed, 8)
                 : take_floats(payload, TiPoints::polar);
    }
    if (type_ == static_cast<std::uint32_t>(TiTlv::points)) {
      demo_points_ = true;
      return area ? take_floats(payload, TiPoints::spherical) : take_points(payload);
    }
    if (type_ == static_cast<std::uint32_t>(TiTlv::side_info)) frame_.side_info_ = payload;
    if (is_lab_item()) {
      lab_items_ = true;
      if (!take_of_lab(payload)) damaged_ = type_;
    }
    return true;
  }

  /// Of xWRL sensors and of TI's laboratories.
  [[nodiscard]] bool is_lab_item() const {
    return type_ >= static_cast<std::uint32_t>(TiTlv::packed_points) &&
           frame_.header_.layout == TiLayout::demo;
  }

  bool take_of_lab(Bytes payload) {
    if (demo_points_) return true;
    switch (static_cast<TiTlv>(type_)) {
      case TiTlv::packed_points:
        return take_in_units(payload, TiPoints::packed, 10);
      case TiTlv::compressed_points:
        return take_in_units(payload, TiPoints::compressed, 8);
      case TiTlv::spherical_points:
        return take_floats(payload, TiPoints::spherical);
      default:
        return true;
    }
  }

  bool take_floats(Bytes payload, TiPoints encoding) {
    return payload.size() % 16 == 0 && set_points(payload, encoding, payload.size() / 16);
  }

  /// Points of `bytes`, with their units before them.
  bool take_in_units(Bytes payload, TiPoints encoding, std::size_t bytes) {
    if (payload.empty()) return set_points(payload, encoding, 0);
    return payload.size() >= 20 && (payload.size() - 20) % bytes == 0 &&
           set_points(payload, encoding, (payload.size() - 20) / bytes);
  }

  bool set_points(Bytes payload, TiPoints encoding, std::size_t points) {
    frame_.encoding_ = encoding;
    frame_.points_ = points;
    frame_.coordinates_ = payload;
    return true;
  }

  bool take_points(Bytes payload) {
    if (frame_.header_.major() >= 3) return take_floats(payload, TiPoints::cartesian);
    if (payload.size() < 4) return false;
    const std::size_t points = load_le<std::uint16_t>(payload.data());
    const unsigned q = load_le<std::uint16_t>(&payload[2]);
    if (q > 15 || payload.size() - 4 != 12 * points) return false;
    frame_.fixed_point_scale_ = 1.0F / static_cast<float>(1U << q);
    return set_points(payload.subspan(4), TiPoints::fixed, points);
  }

  TiFrame frame_;
  std::uint64_t examined_ = 0;
  std::uint64_t start_ = 0;  ///< of the candidate frame
  std::size_t scanned_ = 8;  ///< up to here it contains no other magic word
  TiRefusal refusal_;
  TiFault fault_ = TiFault::none;  ///< why parse() refused
  std::uint32_t type_ = 0;         ///< of the item being read
  std::uint32_t damaged_ = 0;      ///< type of a laboratory's item of points of another length
  bool lab_items_ = false,         ///< the frame has items of TI's laboratories
      demo_points_ = false;        ///< the frame has the demo's item of points
};

using TiDecoder = StreamDecoder<TiFraming>;  ///< of a byte stream to frames

}  // namespace wayfare::decode
