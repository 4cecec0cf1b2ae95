// EXPECT: a framing has a member look
#include <wayfare/decode/stream_decoder.hpp>

using namespace wayfare::decode;

/// Lines of text.
struct Lines {
  using Message = Bytes;
  static constexpr std::size_t kCapacity = 80;
#ifndef WAYFARE_MUST_FAIL
  Look look(const Front& front, DecoderStatistics&) {
    for (std::size_t i = 0; i < front.bytes.size(); ++i)
      if (front.bytes[i] == '\n') return Look::frame(i + 1);
    return front.bytes.size() < kCapacity ? Look::need(front.bytes.size() + 1) : Look::skip(1);
  }
#endif
  template <class Sink>
  void deliver(Bytes bytes, std::uint64_t, Sink& sink) {
    sink(bytes);
  }
  [[nodiscard]] std::uint64_t examined() const { return 0; }
};

StreamDecoder<Lines> decoder;
