#pragma once

// Packets out of the byte stream of a SLAMTEC RPLIDAR: descriptors, single answers, nodes and
// capsules, whichever the last descriptor announced.

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>

#include <wayfare/core/detail/bytes.hpp>
#include <wayfare/decode/detail/line_time.hpp>
#include <wayfare/decode/detail/rplidar_packet.hpp>
#include <wayfare/decode/rplidar_points.hpp>
#include <wayfare/decode/rplidar_protocol.hpp>
#include <wayfare/decode/rplidar_scan.hpp>
#include <wayfare/decode/stream_decoder.hpp>

namespace wayfare::decode {

/// Framing of what an RPLIDAR sends. Outside of a known answer only a descriptor is looked for. A
/// request ends the answer before it, so after sending one call `expect_reply()`; without it a
/// descriptor is recognised as well, but a short answer behind a cut capsule has to wait.
///
/// Nodes have three check bits and no checksum. One that follows another is taken where the bits
/// are right, the angle went on by less than 10°, and the next node does too, or none begins inside
/// it. After damage the place is chosen of five whose nodes, up to twelve, go on longest in this
/// way, at least three.
class RplidarFraming {
 public:
  using Message = RplidarPacket;
  static constexpr std::size_t kCapacity = 256;

  RplidarFraming() = default;
  /// For a stream that begins inside an answer.
  explicit RplidarFraming(RplidarAnswer inside) { begin(inside); }

  void expect_reply() { begin(RplidarAnswer::none); }

  Look look(const Front& front, DecoderStatistics& statistics) {
    examined_ += std::min<std::size_t>(front.bytes.size(), kCapacity);
    is_descriptor_ = false;
    switch (answer_) {
      case RplidarAnswer::none:
        return look_for_descriptor(front);
      case RplidarAnswer::node:
        return look_for_node(front, statistics);
      case RplidarAnswer::express:
      case RplidarAnswer::dense:
        return look_for_capsule(front, 84, statistics);
      case RplidarAnswer::ultra:
        return look_for_capsule(front, 132, statistics);
      default:
        return take_reply(front);
    }
  }

  template <class Sink>
  void deliver(Bytes bytes, std::uint64_t position, Sink& sink) {
    const RplidarPacket packet(is_descriptor_ ? answer_ : delivered_, is_descriptor_, position,
                               bytes);
    sink(packet);
  }
  [[nodiscard]] std::uint64_t examined() const { return examined_; }

 private:
  static constexpr std::size_t kNode = 5, kChain = kRplidarChain, kLeastChain = 3;
  static constexpr std::size_t kSight = kNode * kChain + 4;  ///< bytes of twelve nodes, five places

  void begin(RplidarAnswer answer, std::uint32_t length = 0) {
    answer_ = answer;
    length_ = length;
    locked_ = true;
    last_angle_ = -1;
  }

  Look take_descriptor(const RplidarDescriptor& d) {
    begin(d.answer, d.length);
    is_descriptor_ = true;
    return Look::frame(RplidarDescriptor::kBytes);
  }

  /// Where in `b` a descriptor begins, or may begin where more bytes are to come; else b.size().
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
    const Bytes b = front.bytes.first(std::min(front.bytes.size(), kCapacity));
    const std::size_t at = find_descriptor(b, front.ended);
    if (at != 0) return Look::skip(at);
    if (const auto d = rplidar_descriptor(b)) return take_descriptor(*d);
    return Look::need(RplidarDescriptor::kBytes);
  }

  Look take_reply(const Front& front) {
    if (front.bytes.size() < length_) return Look::need(length_);
    delivered_ = answer_;
    const std::size_t n = length_;
    begin(RplidarAnswer::none);
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
    delivered_ = answer_;
    if (is_rplidar_capsule(b.first(size))) return Look::frame(size);
    ++statistics.checksum_failures;
    return Look::skip(1);
  }

  Look look_for_node(const Front& front, DecoderStatistics& statistics) {
    return look_at_nodes(front, locked_ ? 2 * kNode : kSight, statistics);
  }

  /// The nodes in the first `sight` bytes, up to where a descriptor begins.
  Look look_at_nodes(const Front& front, std::size_t sight, DecoderStatistics& statistics) {
    const std::size_t with_descriptor = sight + RplidarDescriptor::kBytes - 1;
    const Bytes b = front.bytes.first(std::min(front.bytes.size(), with_descriptor));
    if (b.size() < sight && !front.ended) return Look::need(sight);
    const std::size_t descriptor = find_descriptor(b, front.ended);
    if (descriptor < std::min(sight, b.size())) {
      if (b.size() - descriptor < RplidarDescriptor::kBytes && !front.ended)
        return Look::need(b.size() + 1);
      if (descriptor == 0) return take_descriptor(*rplidar_descriptor(b));
    }
    const Bytes nodes = b.first(std::min(descriptor, b.size()));
    if (nodes.size() < kNode) return Look::skip(nodes.size());
    delivered_ = RplidarAnswer::node;
    if (!locked_) return relock(nodes);
    const std::uint8_t* p = nodes.data();
    if (!is_rplidar_node(p) ||
        (last_angle_ >= 0 && !rplidar_follows(rplidar_node_angle(p), last_angle_)))
      return unlock(front, statistics);
    if (nodes.size() < 2 * kNode || rplidar_chain(nodes.first(2 * kNode), 0) == 2)
      return take_node(p);
    // What follows is damaged, or this is put together of two halves and a whole one begins in it.
    if (sight < kSight) return look_at_nodes(front, kSight, statistics);
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
    const bool goes_on =
        last_angle_ >= 0 && rplidar_follows(rplidar_node_angle(b.data()), last_angle_);
    return goes_on || here >= kLeastChain ? take_node(b.data()) : Look::skip(1);
  }

  Look take_node(const std::uint8_t* p) {
    locked_ = true;
    last_angle_ = rplidar_node_angle(p);
    return Look::frame(kNode);
  }

  RplidarAnswer answer_ = RplidarAnswer::none;     ///< being received
  RplidarAnswer delivered_ = RplidarAnswer::none;  ///< what the frame just found is
  std::uint32_t length_ = 0;
  bool is_descriptor_ = false;
  bool locked_ = true;
  int last_angle_ = -1;  ///< of the node before, 1/64°
  std::uint64_t examined_ = 0;
};

using RplidarDecoder = StreamDecoder<RplidarFraming>;

/// From an RPLIDAR's bytes, while they come, to whole turns with the times of their points.
class RplidarStream {
 public:
  explicit RplidarStream(int baud) : baud_(baud) {}

  /// Takes the next bytes, the last of which arrived at `arrived`; calls `sink(const RplidarTurn&)`
  /// with every whole turn they end.
  template <class Sink>
  void feed(Bytes bytes, LogTime arrived, Sink&& sink) {
    fed_ += bytes.size();
    decoder_.feed(bytes, [&](const RplidarPacket& packet) { take(packet, arrived, sink); });
  }

  [[nodiscard]] const DecoderStatistics& statistics() const { return decoder_.statistics(); }

 private:
  template <class Sink>
  void take(const RplidarPacket& packet, LogTime arrived, Sink& sink) {
    if (packet.answer() == RplidarAnswer::sample_rate && !packet.is_descriptor()) {
      rate_ = rplidar_sample_rate(packet.bytes()).value_or(rate_);
      return;
    }
    // A new request began in the middle of a turn.
    if (packet.is_descriptor()) turns_.finish([](const RplidarTurn&) {});
    const bool nodes = packet.answer() == RplidarAnswer::node;
    const Duration sample = std::chrono::microseconds(nodes ? rate_.standard_us : rate_.express_us);
    const std::uint64_t end = packet.position() + packet.bytes().size();
    const LogTime last =
        arrived - line_time(fed_ - end, baud_) - rplidar_delay(packet.answer(), sample, baud_);
    unpacker_.add(packet, [&](std::span<const RplidarPoint> points) {
      turns_.add(points, last, sample, [&](const RplidarTurn& turn) {
        if (turn.whole) sink(turn);
      });
    });
  }

  int baud_;
  RplidarDecoder decoder_;
  RplidarUnpacker unpacker_;
  RplidarTurns<> turns_;
  /// Samples of an A1 until the device says otherwise: 2000 nodes a second, 4000 in capsules.
  RplidarSampleRate rate_ = {500, 250};
  std::uint64_t fed_ = 0;
};

}  // namespace wayfare::decode
