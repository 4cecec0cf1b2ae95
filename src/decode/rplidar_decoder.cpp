#include <wayfare/decode/rplidar_decoder.hpp>

#include <algorithm>

namespace wayfare::decode {

namespace {

constexpr std::size_t kNode = 5, kChain = kRplidarChain, kLeastChain = 3;
constexpr std::size_t kWindow = kNode * kChain + 4;  ///< twelve nodes at five offsets
constexpr std::size_t kSearched = 256;  ///< bytes in which a descriptor is searched for

/// Where in `b` a descriptor begins, or may begin when more bytes can follow; else b.size().
std::size_t find_descriptor(Bytes b, bool ended) {
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

}  // namespace

Look RplidarFraming::look(const Front& front, DecoderStatistics& statistics) {
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

void RplidarFraming::expect(RplidarResponse response, std::uint32_t length) {
  response_ = response;
  length_ = length;
  locked_ = true;
  last_angle_ = -1;
}

Look RplidarFraming::take_descriptor(const RplidarDescriptor& d) {
  expect(d.response, d.length);
  is_descriptor_ = true;
  return Look::frame(RplidarDescriptor::kBytes);
}

Look RplidarFraming::look_for_descriptor(const Front& front) {
  const Bytes b = front.bytes.first(std::min(front.bytes.size(), kSearched));
  const std::size_t at = find_descriptor(b, front.ended);
  if (at != 0) return Look::skip(at);
  if (const auto d = rplidar_descriptor(b)) return take_descriptor(*d);
  return Look::need(RplidarDescriptor::kBytes);
}

Look RplidarFraming::look_for_scan(const Front& front, DecoderStatistics& statistics) {
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

Look RplidarFraming::take_reply(const Front& front) {
  if (front.bytes.size() < length_) return Look::need(length_);
  delivered_ = response_;
  const std::size_t n = length_;
  expect(RplidarResponse::none);
  return Look::frame(n);
}

Look RplidarFraming::look_for_capsule(const Front& front, std::size_t size,
                                      DecoderStatistics& statistics) {
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

Look RplidarFraming::look_for_hq_capsule(const Front& front, DecoderStatistics& statistics) {
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

Look RplidarFraming::look_for_node(const Front& front, DecoderStatistics& statistics) {
  return look_at_nodes(front, locked_ ? 2 * kNode : kWindow, statistics);
}

Look RplidarFraming::look_at_nodes(const Front& front, std::size_t window,
                                   DecoderStatistics& statistics) {
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

Look RplidarFraming::unlock(const Front& front, DecoderStatistics& statistics) {
  locked_ = false;
  ++statistics.malformed;
  return look_for_node(front, statistics);
}

Look RplidarFraming::relock(Bytes b) {
  const std::size_t here = rplidar_chain(b, 0);
  for (std::size_t shift = 1; shift < kNode; ++shift)
    if (rplidar_chain(b, shift) > here) return Look::skip(1);
  if (here == 0) return Look::skip(1);
  const bool continues =
      last_angle_ >= 0 && rplidar_follows(rplidar_node_angle(b.data()), last_angle_);
  return continues || here >= kLeastChain ? take_node(b.data()) : Look::skip(1);
}

Look RplidarFraming::take_node(const std::uint8_t* p) {
  locked_ = true;
  last_angle_ = rplidar_node_angle(p);
  return Look::frame(kNode);
}

}  // namespace wayfare::decode
