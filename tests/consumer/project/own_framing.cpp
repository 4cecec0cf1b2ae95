#include "links.hpp"

#include <wayfare/decode/stream_decoder.hpp>

// A protocol of one's own: lines of text, none longer than eighty bytes.
namespace {

struct Lines {
  using Message = wayfare::decode::Bytes;
  static constexpr std::size_t kCapacity = 80;
  wayfare::decode::Look look(const wayfare::decode::Front& front,
                             wayfare::decode::DecoderStatistics&) {
    using wayfare::decode::Look;
    for (std::size_t i = 0; i < front.bytes.size() && i < kCapacity; ++i)
      if (++count, front.bytes[i] == '\n') return Look::frame(i + 1);
    return front.bytes.size() < kCapacity ? Look::need(front.bytes.size() + 1) : Look::skip(1);
  }
  template <class Sink>
  void deliver(wayfare::decode::Bytes bytes, std::uint64_t, Sink& sink) {
    sink(bytes.first(bytes.size() - 1));
  }
  [[nodiscard]] std::uint64_t examined() const { return count; }
  std::uint64_t count = 0;
};

}  // namespace

bool own_framing() {
  wayfare::decode::StreamDecoder<Lines> decoder;
  const std::uint8_t text[] = {'a', '\n', 'b', 'c', '\n', 'd'};
  std::size_t lines = 0, letters = 0;
  const auto sink = [&](wayfare::decode::Bytes line) { ++lines, letters += line.size(); };
  for (const std::uint8_t& letter : text) decoder.feed({&letter, 1}, sink);
  decoder.finish(sink);
  return lines == 2 && letters == 3 && decoder.statistics().skipped_bytes == 1;
}
