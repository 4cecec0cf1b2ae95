#pragma once

// The common interface of all decoders: bytes in, in any chunks; messages out, to a callable.
//
//   TiDecoder decoder;
//   decoder.feed(bytes, [](const TiFrame& frame) { … });   // as often as bytes arrive
//   decoder.finish([](const TiFrame& frame) { … });        // where the stream ends
//
// The device-specific part is a framing: it inspects the bytes at the front of the stream and
// returns how many to skip, the length of the frame that begins there, or how many bytes it needs
// to decide. Messages refer to the decoder's bytes and are valid until the callable returns.
// Nothing here allocates; a decoder contains a buffer of two of the largest frames and is best not
// on a stack.

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <utility>

#include <wayfare/core/contract.hpp>
#include <wayfare/core/detail/bytes.hpp>
#include <wayfare/core/time.hpp>

namespace wayfare::decode {

/// Time that `bytes` take on a line of `baud` > 0: start bit, eight bits, stop bit each.
[[nodiscard]] inline Duration line_time(std::uint64_t bytes, int baud) {
  WAYFARE_EXPECTS(baud > 0, "the rate of a line must be positive");
  return from_seconds(10.0 * static_cast<double>(bytes) / static_cast<double>(baud));
}

/// Counts of bytes and frames so far.
struct DecoderStatistics {
  std::uint64_t bytes = 0;              ///< fed
  std::uint64_t frames = 0;             ///< delivered
  std::uint64_t skipped_bytes = 0;      ///< in no frame
  std::uint64_t checksum_failures = 0;  ///< whole frames whose checksum was wrong
  std::uint64_t malformed = 0;          ///< candidate frames with inconsistent lengths or counts

  bool operator==(const DecoderStatistics&) const = default;  ///< all counts
};

/// The work of a framing, which determines its run time. Depends on the chunks.
struct DecoderWork {
  std::uint64_t looks = 0;     ///< calls of look()
  std::uint64_t examined = 0;  ///< bytes searched, added or compared, with repetitions
};

/// A framing's result on the bytes at the front.
struct Look {
  /// What to do with them.
  enum class Kind : std::uint8_t {
    need,   ///< more bytes are needed
    frame,  ///< a frame begins here
    skip,   ///< bytes in no frame
  };
  Kind kind = Kind::need;  ///< what to do
  /// need: number of bytes required before the next look, more than present and at most the
  /// framing's kCapacity. frame: its length. skip: number of bytes in no frame, at least one.
  std::size_t bytes = 0;
  std::size_t advance = 0;  ///< frame: where to look next, at least 1 and at most its length

  /// Wait for more bytes.
  [[nodiscard]] static constexpr Look need(std::size_t bytes) { return {Kind::need, bytes, 0}; }
  /// Pass over bytes that are in no frame.
  [[nodiscard]] static constexpr Look skip(std::size_t bytes) { return {Kind::skip, bytes, 0}; }
  /// Deliver a frame, and look next after it.
  [[nodiscard]] static constexpr Look frame(std::size_t bytes) {
    return {Kind::frame, bytes, bytes};
  }
};

/// The bytes a framing inspects.
struct Front {
  Bytes bytes;                 ///< never empty
  std::uint64_t position = 0;  ///< of the first of them in the stream
  bool ended = false;          ///< no more bytes follow
};

namespace detail {

struct AnySink {
  void operator()(const auto& /*message*/) const {}
};
template <class F>
inline constexpr bool kLooks = requires(F framing, const Front& front, DecoderStatistics& s) {
  { framing.look(front, s) } -> std::same_as<Look>;
};
template <class F>
inline constexpr bool kDelivers = requires(F framing, Bytes bytes, AnySink sink) {
  framing.deliver(bytes, std::uint64_t{}, sink);
};
template <class F>
inline constexpr bool kCountsItsWork = requires(const F& framing) {
  { framing.examined() } -> std::same_as<std::uint64_t>;
};

}  // namespace detail

/// What a device brings: the type of its messages, the length of its largest frame, `look` at the
/// bytes at the front, `deliver(bytes, position, sink)` of a frame, which calls the sink with a
/// message, and the number of bytes `examined` so far. It may have `end_stream()`, which returns it
/// to its initial state before another stream, where the positions of the bytes do not tell it. See
/// testing::DecoderLaws.
template <class F>
concept Framing = std::default_initializable<F> && requires {
  typename F::Message;
  { F::kCapacity } -> std::convertible_to<std::size_t>;
} && detail::kLooks<F> && detail::kDelivers<F> && detail::kCountsItsWork<F>;

namespace detail {

/// What a type lacks to be a framing, in words.
template <class F>
consteval bool check_framing() {
  static_assert(
      requires { typename F::Message; },
      "wayfare: a framing names the type of its messages, using Message = X");
  static_assert(
      requires {
        { F::kCapacity } -> std::convertible_to<std::size_t>;
      },
      "wayfare: a framing has the length of its largest frame, static constexpr "
      "std::size_t kCapacity");
  static_assert(kLooks<F>,
                "wayfare: a framing has a member look(const Front&, DecoderStatistics&), which "
                "returns a Look");
  static_assert(kDelivers<F>,
                "wayfare: a framing has a member deliver(Bytes, std::uint64_t position, sink), a "
                "template of the sink, which it calls with a message");
  static_assert(kCountsItsWork<F>,
                "wayfare: a framing has a const member examined(), which returns the number of "
                "bytes it examined, a std::uint64_t");
  static_assert(std::default_initializable<F>, "wayfare: a framing has a default constructor");
  return true;
}

}  // namespace detail

/// Buffers the stream for a framing, so that the result does not depend on the chunks. A sink must
/// not feed the decoder that calls it. A copy continues the stream on its own.
template <class F>
class StreamDecoder {
  static_assert(detail::check_framing<F>());

 public:
  using Message = typename F::Message;  ///< what sinks receive

  StreamDecoder() = default;
  /// With a framing that has settings.
  explicit StreamDecoder(F framing) : framing_(std::move(framing)) {}

  /// Takes the next bytes of the stream; `sink` is called with every message they complete.
  template <class Sink>
  void feed(Bytes bytes, Sink&& sink) {
    statistics_.bytes += bytes.size();
    while (held() != 0 && !bytes.empty()) {
      bytes = bytes.subspan(top_up(bytes));
      if (held() >= need_) begin_ += walk({&buffer_[begin_], held()}, false, sink);
      if (begin_ == end_) begin_ = end_ = 0;
    }
    if (bytes.empty()) return;
    const std::size_t used = walk(bytes, false, sink);
    top_up(bytes.subspan(used));
  }

  /// Ends the stream: decodes the buffered bytes. The decoder may then be fed another stream, which
  /// it decodes as a new one would; counts and positions continue.
  template <class Sink>
  void finish(Sink&& sink) {
    if (held() != 0) walk({&buffer_[begin_], held()}, true, sink);
    begin_ = end_ = 0;
    if constexpr (requires { framing_.end_stream(); }) framing_.end_stream();
  }

  /// Counts so far.
  [[nodiscard]] const DecoderStatistics& statistics() const { return statistics_; }
  /// Run time so far, in operations.
  [[nodiscard]] DecoderWork work() const { return {looks_, framing_.examined()}; }
  /// Bytes of a frame not yet complete.
  [[nodiscard]] std::size_t held() const { return end_ - begin_; }
  /// To set it between frames.
  [[nodiscard]] F& framing() { return framing_; }
  /// The device's part.
  [[nodiscard]] const F& framing() const { return framing_; }

 private:
  /// Buffers the bytes that are needed; returns their number.
  std::size_t top_up(Bytes bytes) {
    const std::size_t n = std::min(bytes.size(), need_ - held());
    if (n == 0) return 0;
    if (end_ + n > buffer_.size()) {  // at least kCapacity bytes were consumed since the last time
      std::memmove(buffer_.data(), &buffer_[begin_], held());
      end_ -= begin_;
      begin_ = 0;
    }
    std::memcpy(&buffer_[end_], bytes.data(), n);
    end_ += n;
    return n;
  }

  /// Decodes bytes from the front until more are needed; returns the number consumed.
  template <class Sink>
  std::size_t walk(Bytes bytes, bool ended, Sink& sink) {
    std::size_t at = 0;
    while (at < bytes.size()) {
      const Bytes rest = bytes.subspan(at);
      Look look = framing_.look({rest, position_, ended}, statistics_);
      ++looks_;
      if (look.kind == Look::Kind::need && !ended) {
        WAYFARE_EXPECTS(look.bytes > rest.size() && look.bytes <= F::kCapacity,
                        "a framing needs more bytes than are present, up to its capacity");
        need_ = look.bytes;
        return at;
      }
      if (look.kind == Look::Kind::need) look = Look::skip(1);
      if (look.kind == Look::Kind::frame) {
        ++statistics_.frames;
        claimed_ = std::max(claimed_, position_ + look.bytes);
        framing_.deliver(rest.first(look.bytes), position_, sink);
      }
      const std::size_t n = look.kind == Look::Kind::frame ? look.advance : look.bytes;
      WAYFARE_EXPECTS(n > 0 && n <= rest.size(), "a framing advances by some of the bytes present");
      at += n;
      position_ += n;
      if (position_ > claimed_) statistics_.skipped_bytes += position_ - claimed_;
      claimed_ = std::max(claimed_, position_);
    }
    return at;
  }

  F framing_{};
  DecoderStatistics statistics_;
  std::uint64_t position_ = 0;  ///< of the front in the stream
  std::uint64_t looks_ = 0;
  std::uint64_t claimed_ = 0;  ///< end of the bytes in frames or counted as skipped
  std::size_t need_ = F::kCapacity, begin_ = 0, end_ = 0;
  std::array<std::uint8_t, 2 * F::kCapacity> buffer_;  // NOLINT: written before it is read
};

}  // namespace wayfare::decode
