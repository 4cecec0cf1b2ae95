#pragma once

// Messages of u-blox receivers, little endian: B5 62, class, id, length of the payload in two
// bytes, payload, two bytes of checksum (u-blox, F9 HPG 1.32 Interface Description, UBX-22008968).
//
//   UbxDecoder decoder;
//   decoder.feed(bytes, [](const UbxMessage& m) { … });
//
// The contents of messages: <wayfare/decode/ubx_messages.hpp>.

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include <wayfare/core/detail/bytes.hpp>
#include <wayfare/decode/detail/running_sums.hpp>
#include <wayfare/decode/stream_decoder.hpp>

namespace wayfare::decode {

/// Class and id of the messages with a type in ubx_messages.hpp.
enum class UbxId : std::uint16_t {
  nav_pvt = 0x0107,    ///< position, velocity, time
  rxm_sfrbx = 0x0213,  ///< subframe of a navigation message
  rxm_rawx = 0x0215,   ///< ranges, Doppler shifts, carrier phases
};

/// A message whose checksum is right. It refers to the decoder's bytes.
class UbxMessage {
 public:
  UbxMessage() = default;
  /// All bytes of a message, at this position in the stream.
  UbxMessage(std::uint64_t position, Bytes bytes) : position_(position), bytes_(bytes) {}

  /// Class in the upper byte, id in the lower one.
  [[nodiscard]] UbxId id() const { return static_cast<UbxId>(bytes_[2] << 8 | bytes_[3]); }
  /// Between length and checksum.
  [[nodiscard]] Bytes payload() const { return bytes_.subspan(6, bytes_.size() - 8); }
  [[nodiscard]] std::uint64_t position() const { return position_; }  ///< in the stream
  [[nodiscard]] Bytes bytes() const { return bytes_; }                ///< of the whole message

 private:
  std::uint64_t position_ = 0;
  Bytes bytes_;
};

namespace detail {

/// Fletcher's checksum of 8 bits (RFC 1145), as the receivers compute it.
struct Fletcher8 {
  std::uint8_t a = 0, b = 0;
};
[[nodiscard]] inline Fletcher8 with_byte(Fletcher8 sum, std::uint8_t byte) {
  sum.a = static_cast<std::uint8_t>(sum.a + byte);
  sum.b = static_cast<std::uint8_t>(sum.b + sum.a);
  return sum;
}
[[nodiscard]] inline Fletcher8 fletcher_sum(Bytes bytes) {
  Fletcher8 sum;
  for (const std::uint8_t byte : bytes) sum = with_byte(sum, byte);
  return sum;
}

}  // namespace detail

/// Writes a message to `out`; returns its length, or 0 where it does not fit.
[[nodiscard]] inline std::size_t write_ubx(UbxId id, Bytes payload, std::span<std::uint8_t> out) {
  const std::size_t total = payload.size() + 8;
  if (payload.size() > 0xFFFF || out.size() < total) return 0;
  out[0] = 0xB5;
  out[1] = 0x62;
  store_be(static_cast<std::uint16_t>(id), &out[2]);
  store_le(static_cast<std::uint16_t>(payload.size()), &out[4]);
  if (!payload.empty()) std::memcpy(&out[6], payload.data(), payload.size());
  const detail::Fletcher8 sum = detail::fletcher_sum(out.subspan(2, total - 4));
  out[total - 2] = sum.a;
  out[total - 1] = sum.b;
  return total;
}

/// Framing of the messages. A payload longer than `kMaxPayload` bytes is rejected as damaged. The
/// longest of the messages here is RXM-RAWX with 255 measurements, 8176 bytes.
///
/// After a wrong checksum the search resumes one byte later, with overlapping candidates. Their
/// checksums are differences of running sums, so that no byte is added more than twice.
template <std::size_t kMaxPayload = 8192>
class BasicUbxFraming {
 public:
  using Message = UbxMessage;                                ///< what the sink is given
  static constexpr std::size_t kCapacity = kMaxPayload + 8;  ///< bytes of the largest frame

  /// What begins at the front.
  Look look(const Front& front, DecoderStatistics& statistics) {
    const Bytes b = front.bytes;
    if (b[0] != 0xB5) {
      const std::size_t n = bytes_before(b, 0xB5);
      examined_ += n;
      return Look::skip(n);
    }
    if (b.size() < 2) return Look::need(2);
    if (b[1] != 0x62) return Look::skip(1);
    if (b.size() < 6) return Look::need(6);
    const std::size_t length = load_le<std::uint16_t>(&b[4]);
    if (length > kMaxPayload) {
      ++statistics.malformed;
      return Look::skip(1);
    }
    const std::size_t total = length + 8;
    if (b.size() < total) return Look::need(total);
    if (checksum_matches(b.first(total), front.position)) return Look::frame(total);
    ++statistics.checksum_failures;
    return Look::skip(1);
  }

  /// Gives the sink the message of a frame.
  template <class Sink>
  void deliver(Bytes bytes, std::uint64_t position, Sink& sink) {
    const UbxMessage message(position, bytes);
    sink(message);
  }
  /// Bytes compared or added so far.
  [[nodiscard]] std::uint64_t examined() const { return examined_; }

 private:
  bool checksum_matches(Bytes b, std::uint64_t position) {
    if (!sums_.contain(position)) {
      examined_ += b.size();
      const detail::Fletcher8 sum = detail::fletcher_sum(b.subspan(2, b.size() - 4));
      if (b[b.size() - 2] == sum.a && b[b.size() - 1] == sum.b) return true;
      sums_.start(position);
    }
    examined_ += sums_.extend(position, b, detail::with_byte);
    // The checksum is over n bytes from `first` on: a = A(end) − A(first), and each of its partial
    // sums is A(k) − A(first), so that b = B(end) − B(first) − n A(first).
    const std::size_t n = b.size() - 4;
    const detail::Fletcher8 first = sums_.before(position + 2),
                            end = sums_.before(position + 2 + n);
    const auto a = static_cast<std::uint8_t>(end.a - first.a);
    const auto sum =
        static_cast<std::uint8_t>(end.b - first.b - static_cast<unsigned>(n) * first.a);
    return b[b.size() - 2] == a && b[b.size() - 1] == sum;
  }

  detail::RunningSums<detail::Fletcher8, kCapacity> sums_;
  std::uint64_t examined_ = 0;
};

/// With payloads of up to 8192 bytes.
using UbxFraming = BasicUbxFraming<>;
/// Decodes a receiver's stream.
using UbxDecoder = StreamDecoder<UbxFraming>;

}  // namespace wayfare::decode
