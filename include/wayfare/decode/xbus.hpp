#pragma once

// Messages of an Xsens device's bus, big endian: FA, bus id, message id, length, data, checksum,
// all bytes after FA adding up to 0 modulo 256 (Xsens, MT Low Level Communication Protocol,
// MT0101P). FA also occurs in data.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include <wayfare/core/detail/bytes.hpp>
#include <wayfare/decode/detail/running_sums.hpp>
#include <wayfare/decode/stream_decoder.hpp>

namespace wayfare::decode {

/// Message ids; the response to a request has the next number.
enum class XbusId : std::uint8_t {
  configuration = 0x0D,                 ///< of a device and its trackers
  goto_measurement = 0x10,              ///< request
  goto_config = 0x30,                   ///< request
  mt_data = 0x32,                       ///< legacy measurements
  mt_data2 = 0x36,                      ///< measurements
  wake_up = 0x3E,                       ///< the device has started
  error = 0x42,                         ///< code in the data
  request_filter_profiles = 0x62,       ///< request: which there are
  filter_profiles = 0x63,               ///< those there are
  request_filter_profile = 0x64,        ///< request: with data to select one
  filter_profile = 0x65,                ///< the selected one
  request_output_configuration = 0xC0,  ///< request: with data to set it
  output_configuration = 0xC1,          ///< what measurements contain
};

/// A message whose checksum is right. It refers to the decoder's bytes.
class XbusMessage {
 public:
  XbusMessage() = default;
  /// Of a checked message; `position`: of its first byte in the stream.
  XbusMessage(std::uint64_t position, Bytes bytes) : position_(position), bytes_(bytes) {}

  [[nodiscard]] std::uint8_t bus() const { return bytes_[1]; }  ///< FF: master or single device
  /// Kind of message.
  [[nodiscard]] XbusId id() const { return static_cast<XbusId>(bytes_[2]); }
  /// Without head and checksum.
  [[nodiscard]] Bytes data() const {
    const std::size_t head = bytes_[3] == 0xFF ? 6 : 4;
    return bytes_.subspan(head, bytes_.size() - head - 1);
  }
  /// Of its first byte in the stream.
  [[nodiscard]] std::uint64_t position() const { return position_; }
  /// All of it.
  [[nodiscard]] Bytes bytes() const { return bytes_; }

 private:
  std::uint64_t position_ = 0;
  Bytes bytes_;
};

/// The sum of all bytes modulo 256, computed eight at a time.
[[nodiscard]] inline std::uint8_t byte_sum(Bytes bytes) {
  constexpr std::uint64_t kLow = 0x7F7F7F7F7F7F7F7FULL;
  std::uint64_t lanes = 0;  // eight sums without carries between them
  std::size_t i = 0;
  for (; i + 8 <= bytes.size(); i += 8) {
    std::uint64_t eight = 0;
    std::memcpy(&eight, &bytes[i], 8);
    lanes = ((lanes & kLow) + (eight & kLow)) ^ ((lanes ^ eight) & ~kLow);
  }
  unsigned sum = 0;
  for (; i < bytes.size(); ++i) sum += bytes[i];
  for (; lanes != 0; lanes >>= 8) sum += static_cast<unsigned>(lanes & 0xFF);
  return static_cast<std::uint8_t>(sum);
}

/// Writes a message to `out`; returns its length, or 0 where it does not fit or the data exceeds
/// the longest message.
[[nodiscard]] inline std::size_t write_xbus(std::uint8_t bus, XbusId id, Bytes data,
                                            std::span<std::uint8_t> out) {
  const std::size_t head = data.size() < 0xFF ? 4 : 6, total = head + data.size() + 1;
  if (data.size() > 0xFFFF || out.size() < total) return 0;
  out[0] = 0xFA;
  out[1] = bus;
  out[2] = static_cast<std::uint8_t>(id);
  out[3] = static_cast<std::uint8_t>(std::min<std::size_t>(data.size(), 0xFF));
  if (head == 6) store_be(static_cast<std::uint16_t>(data.size()), &out[4]);
  std::copy(data.begin(), data.end(), out.begin() + static_cast<std::ptrdiff_t>(head));
  out[total - 1] = static_cast<std::uint8_t>(-byte_sum(out.subspan(1, total - 2)));
  return total;
}

/// Framing of the bus. A message longer than `kMaxData` bytes is rejected as damaged. A false start
/// delays messages until the bytes it claims have arrived: the limit bounds that delay.
///
/// After a wrong checksum the search resumes one byte later, with overlapping candidates. Their
/// sums are differences of running sums, so that no byte is added more than twice.
template <std::size_t kMaxData = 16384>
class BasicXbusFraming {
 public:
  using Message = XbusMessage;  ///< of the bus
  /// Longest message with an extended length.
  static constexpr std::size_t kCapacity = kMaxData + 7;

  /// What begins at the front of the stream.
  Look look(const Front& front, DecoderStatistics& statistics) {
    const Bytes b = front.bytes;
    if (b[0] != 0xFA) {
      const std::size_t n = bytes_before(b, 0xFA);
      examined_ += n;
      return Look::skip(n);
    }
    if (b.size() < 4) return Look::need(4);
    const bool extended = b[3] == 0xFF;
    if (extended && b.size() < 6) return Look::need(6);
    const std::size_t length = extended ? load_be<std::uint16_t>(&b[4]) : b[3];
    if ((extended && length < 0xFF) || length > kMaxData) {
      ++statistics.malformed;
      return Look::skip(1);
    }
    const std::size_t total = (extended ? 6 : 4) + length + 1;
    if (b.size() < total) return Look::need(total);
    if (checksum_matches(b.first(total), front.position)) return Look::frame(total);
    ++statistics.checksum_failures;
    return Look::skip(1);
  }

  /// Passes the message to `sink(const XbusMessage&)`.
  template <class Sink>
  void deliver(Bytes bytes, std::uint64_t position, Sink& sink) {
    const XbusMessage message(position, bytes);
    sink(message);
  }
  /// Number of bytes inspected so far.
  [[nodiscard]] std::uint64_t examined() const { return examined_; }

 private:
  bool checksum_matches(Bytes b, std::uint64_t position) {
    if (!sums_.contain(position)) {
      examined_ += b.size();
      if (byte_sum(b.subspan(1)) == 0) return true;
      sums_.start(position);
    }
    examined_ += sums_.extend(position, b, [](std::uint8_t sum, std::uint8_t byte) {
      return static_cast<std::uint8_t>(sum + byte);
    });
    return sums_.before(position + b.size()) == sums_.before(position + 1);
  }

  detail::RunningSums<std::uint8_t, kCapacity> sums_;
  std::uint64_t examined_ = 0;
};

using XbusFraming = BasicXbusFraming<>;          ///< of any message up to 16 KiB
using XbusDecoder = StreamDecoder<XbusFraming>;  ///< of a byte stream to messages

}  // namespace wayfare::decode
