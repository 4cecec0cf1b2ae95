#pragma once

// Packets from the byte stream of a SLAMTEC RPLIDAR: descriptors, single responses, nodes and
// capsules, of the type the last descriptor announced.

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
  Look look(const Front& front, DecoderStatistics& statistics);

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
  void expect(RplidarResponse response, std::uint32_t length = 0);
  Look take_descriptor(const RplidarDescriptor& d);
  Look look_for_descriptor(const Front& front);
  /// Decides by fixed numbers of bytes: the result does not depend on the chunks.
  Look look_for_scan(const Front& front, DecoderStatistics& statistics);
  Look look_for_capsule(const Front& front, std::size_t size, DecoderStatistics& statistics);
  Look look_for_hq_capsule(const Front& front, DecoderStatistics& statistics);
  Look take_reply(const Front& front);
  Look look_for_node(const Front& front, DecoderStatistics& statistics);
  /// The nodes in the first `window` bytes, up to a descriptor.
  Look look_at_nodes(const Front& front, std::size_t window, DecoderStatistics& statistics);
  Look unlock(const Front& front, DecoderStatistics& statistics);
  Look relock(Bytes b);
  Look take_node(const std::uint8_t* p);

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
