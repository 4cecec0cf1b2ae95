#pragma once

// Packets from the byte stream of a SLAMTEC RPLIDAR: descriptors, single responses, nodes and
// capsules, of the type the last descriptor announced.

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include <wayfare/core/detail/bytes.hpp>
#include <wayfare/decode/rplidar_packet.hpp>
#include <wayfare/decode/rplidar_protocol.hpp>
#include <wayfare/decode/stream_decoder.hpp>

namespace wayfare::decode {

/// Framing of an RPLIDAR's stream. Outside a known response only a descriptor is searched for, and
/// with `running()` a scan that has begun before. A request ends the previous response, so call
/// `expect_reply()` after sending one; a descriptor is recognised without it, but a short response
/// after a truncated capsule is delayed.
///
/// Nodes have three check bits and no checksum. A node after another one is accepted where its bits
/// are right, its angle is within 10° of the previous one, and the same is true of the next node or
/// no node begins inside it. After damage, the offset out of five with the longest chain of such
/// nodes, three to twelve, is chosen.
class RplidarFraming {
 public:
  using Message = RplidarPacket;                  ///< a descriptor, response, node or capsule
  static constexpr std::size_t kCapacity = 1024;  ///< bytes, more than the longest packet

  RplidarFraming() = default;
  /// For streams that begin inside a response of nodes or capsules; others are searched for a
  /// descriptor.
  explicit RplidarFraming(RplidarResponse inside) : inside_(inside) { end_stream(); }
  /// For streams that may begin inside a scan, or whose descriptor may be damaged: twelve nodes of
  /// a laser that turns, a capsule and the head of the next, or an HQ capsule are a scan without a
  /// descriptor.
  [[nodiscard]] static RplidarFraming running() {
    RplidarFraming framing;
    framing.running_ = true;
    return framing;
  }

  /// Ends the current response: the next packet is a descriptor.
  void expect_reply() { expect(RplidarResponse::none); }
  /// Before another stream: as constructed.
  void end_stream() { expect(is_rplidar_scan(inside_) ? inside_ : RplidarResponse::none); }

  /// What begins at the front of the stream.
  Look look(const Front& front, DecoderStatistics& statistics) {
    examined_ += std::min<std::size_t>(front.bytes.size(), kSearched);
    is_descriptor_ = false;
    switch (response_) {
      case RplidarResponse::none:
        return running_ ? look_for_scan(front, statistics) : look_for_descriptor(front);
      case RplidarResponse::node:
        return look_for_node(front, statistics);
      case RplidarResponse::express:
      case RplidarResponse::dense:
        return look_for_capsule(front, 84, statistics);
      case RplidarResponse::ultra:
        return look_for_capsule(front, 132, statistics);
      case RplidarResponse::ultra_dense:
        return look_for_capsule(front, 170, statistics);
      case RplidarResponse::hq:
        return look_for_hq_capsule(front, statistics);
      default:
        return take_reply(front);
    }
  }

  /// Passes the packet to `sink(const RplidarPacket&)`.
  template <class Sink>
  void deliver(Bytes bytes, std::uint64_t position, Sink& sink) {
    const RplidarPacket packet(is_descriptor_ ? response_ : delivered_, is_descriptor_, position,
                               bytes);
    sink(packet);
  }
  /// Number of bytes inspected so far.
  [[nodiscard]] std::uint64_t examined() const { return examined_; }

 private:
  static constexpr std::size_t kNode = 5, kChain = kRplidarChain, kLeastChain = 3;
  static constexpr std::size_t kWindow = kNode * kChain + 4;  ///< twelve nodes at five offsets
  static constexpr std::size_t kSearched = 256;  ///< bytes in which a descriptor is searched for

  void expect(RplidarResponse response, std::uint32_t length = 0) {
    response_ = response;
    length_ = length;
    locked_ = true;
    last_angle_ = -1;
  }

  Look take_descriptor(const RplidarDescriptor& d) {
    expect(d.response, d.length);
    is_descriptor_ = true;
    return Look::frame(RplidarDescriptor::kBytes);
  }

  /// Where in `b` a descriptor begins, or may begin when more bytes can follow; else b.size().
  static std::size_t find_descriptor(Bytes b, bool ended) {
    for (std::size_t i = 0; i < b.size(); ++i) {
      if (b[i] != 0xA5) continue;
      const Bytes rest = b.subspan(i);
      if (rest.size() >= RplidarDescriptor::kBytes) {
        if (rplidar_descriptor(rest)) return i;
      } else if (!ended && (rest.size() == 1 || rest[1] == 0x5A)) {
        return i;
      }
    }
    return b.size();
  }

  Look look_for_descriptor(const Front& front) {
    const Bytes b = front.bytes.first(std::min(front.bytes.size(), kSearched));
    const std::size_t at = find_descriptor(b, front.ended);
    if (at != 0) return Look::skip(at);
    if (const auto d = rplidar_descriptor(b)) return take_descriptor(*d);
    return Look::need(RplidarDescriptor::kBytes);
  }

  /// Decides by fixed numbers of bytes: the result does not depend on the chunks.
  Look look_for_scan(const Front& front, DecoderStatistics& statistics) {
    const Bytes b = front.bytes;
    if (b.size() < RplidarDescriptor::kBytes) return Look::need(RplidarDescriptor::kBytes);
    if (const auto d = rplidar_descriptor(b)) return take_descriptor(*d);
    const std::size_t nodes = rplidar_chain(b, 0);
    if (nodes != kChain && b.size() < kNode * (nodes + 1)) return Look::need(kNode * kChain);
    if (is_rplidar_run(b)) {
      expect(RplidarResponse::node);
      return look_for_node(front, statistics);
    }
    if (b[0] == 0xA5) {
      constexpr std::size_t kBytes = rplidar_packet_bytes(RplidarResponse::hq);
      if (b.size() < kBytes && !front.ended) return Look::need(kBytes);
      examined_ += kBytes;
      if (b.size() >= kBytes && is_rplidar_hq_capsule(b.first(kBytes))) {
        expect(RplidarResponse::hq);
        return look_for_hq_capsule(front, statistics);
      }
    }
    if (b[0] >> 4 != 0xA || b[1] >> 4 != 0x5) return Look::skip(1);
    using enum RplidarResponse;
    for (const RplidarResponse kind : {express, ultra, ultra_dense}) {
      const std::size_t size = rplidar_packet_bytes(kind), run = size + rplidar_capsule_head(kind);
      if (b.size() < run) return Look::need(run);
      if (!is_rplidar_capsule_run(b, kind)) continue;
      expect(kind == express && is_rplidar_dense(b) ? dense : kind);
      return look_for_capsule(front, size, statistics);
    }
    return Look::skip(1);
  }

  Look take_reply(const Front& front) {
    if (front.bytes.size() < length_) return Look::need(length_);
    delivered_ = response_;
    const std::size_t n = length_;
    expect(RplidarResponse::none);
    return Look::frame(n);
  }

  Look look_for_capsule(const Front& front, std::size_t size, DecoderStatistics& statistics) {
    const Bytes b = front.bytes;
    if (b[0] >> 4 != 0xA) return Look::skip(1);
    if (b.size() < 2) return Look::need(2);
    if (b[1] >> 4 != 0x5) return Look::skip(1);
    if (b[0] == 0xA5 && b[1] == 0x5A) {
      if (b.size() < RplidarDescriptor::kBytes) return Look::need(RplidarDescriptor::kBytes);
      if (const auto d = rplidar_descriptor(b)) return take_descriptor(*d);
    }
    if (b.size() < size) return Look::need(size);
    delivered_ = response_;
    if (is_rplidar_capsule(b.first(size))) return Look::frame(size);
    ++statistics.checksum_failures;
    return Look::skip(1);
  }

  Look look_for_hq_capsule(const Front& front, DecoderStatistics& statistics) {
    const Bytes b = front.bytes;
    if (b[0] != 0xA5) return Look::skip(bytes_before(b, 0xA5));
    if (b.size() < RplidarDescriptor::kBytes) return Look::need(RplidarDescriptor::kBytes);
    if (const auto d = rplidar_descriptor(b)) return take_descriptor(*d);
    constexpr std::size_t kBytes = rplidar_packet_bytes(RplidarResponse::hq);
    if (b.size() < kBytes) return Look::need(kBytes);
    examined_ += kBytes;
    delivered_ = response_;
    if (is_rplidar_hq_capsule(b.first(kBytes))) return Look::frame(kBytes);
    ++statistics.checksum_failures;
    return Look::skip(1);
  }

  Look look_for_node(const Front& front, DecoderStatistics& statistics) {
    return look_at_nodes(front, locked_ ? 2 * kNode : kWindow, statistics);
  }

  /// The nodes in the first `window` bytes, up to a descriptor.
  Look look_at_nodes(const Front& front, std::size_t window, DecoderStatistics& statistics) {
    const std::size_t with_descriptor = window + RplidarDescriptor::kBytes - 1;
    const Bytes b = front.bytes.first(std::min(front.bytes.size(), with_descriptor));
    if (b.size() < window && !front.ended) return Look::need(window);
    const std::size_t descriptor = find_descriptor(b, front.ended);
    if (descriptor < std::min(window, b.size())) {
      if (b.size() - descriptor < RplidarDescriptor::kBytes && !front.ended)
        return Look::need(b.size() + 1);
      if (descriptor == 0) return take_descriptor(*rplidar_descriptor(b));
    }
    const Bytes nodes = b.first(std::min(descriptor, b.size()));
    if (nodes.size() < kNode) return Look::skip(nodes.size());
    delivered_ = RplidarResponse::node;
    if (!locked_) return relock(nodes);
    const std::uint8_t* p = nodes.data();
    if (!is_rplidar_node(p) ||
        (last_angle_ >= 0 && !rplidar_follows(rplidar_node_angle(p), last_angle_)))
      return unlock(front, statistics);
    if (nodes.size() < 2 * kNode || rplidar_chain(nodes.first(2 * kNode), 0) == 2)
      return take_node(p);
    // What follows is damaged, or this is composed of two halves and a whole node begins inside it.
    if (window < kWindow) return look_at_nodes(front, kWindow, statistics);
    for (std::size_t shift = 1; shift < kNode; ++shift)
      if (rplidar_chain(nodes, shift) >= kLeastChain) return unlock(front, statistics);
    return take_node(p);
  }

  Look unlock(const Front& front, DecoderStatistics& statistics) {
    locked_ = false;
    ++statistics.malformed;
    return look_for_node(front, statistics);
  }

  Look relock(Bytes b) {
    const std::size_t here = rplidar_chain(b, 0);
    for (std::size_t shift = 1; shift < kNode; ++shift)
      if (rplidar_chain(b, shift) > here) return Look::skip(1);
    if (here == 0) return Look::skip(1);
    const bool continues =
        last_angle_ >= 0 && rplidar_follows(rplidar_node_angle(b.data()), last_angle_);
    return continues || here >= kLeastChain ? take_node(b.data()) : Look::skip(1);
  }

  Look take_node(const std::uint8_t* p) {
    locked_ = true;
    last_angle_ = rplidar_node_angle(p);
    return Look::frame(kNode);
  }

  RplidarResponse inside_ = RplidarResponse::none;     ///< where a stream begins
  RplidarResponse response_ = RplidarResponse::none;   ///< being received
  RplidarResponse delivered_ = RplidarResponse::none;  ///< type of the frame just found
  std::uint32_t length_ = 0;
  bool is_descriptor_ = false;
  bool running_ = false;  ///< also scans without a descriptor are searched for
  bool locked_ = true;
  int last_angle_ = -1;  ///< of the previous node, 1/64°
  std::uint64_t examined_ = 0;
};

using RplidarDecoder = StreamDecoder<RplidarFraming>;  ///< of a byte stream to packets

}  // namespace wayfare::decode
