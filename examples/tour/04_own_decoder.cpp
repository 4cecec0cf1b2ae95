// Readings of a weighing cell from a serial line: a framing of one's own. A frame is 0x5A, the
// number of readings (1 to 16), the readings (grams, 16 bits, low byte first) and a byte that makes
// the sum of all bytes zero. The stream arrives in pieces, with noise between the frames.
#include <cstdio>
#include <numeric>
#include <vector>

#include <wayfare/core/random.hpp>
#include <wayfare/decode/stream_decoder.hpp>

using namespace wayfare::decode;

struct ScaleFraming {
  using Message = std::vector<int>;
  static constexpr std::size_t kCapacity = 3 + 2 * 16;
  Look look(const Front& front, DecoderStatistics& statistics) {
    const Bytes b = front.bytes;
    ++examined_;
    if (b[0] != 0x5A) return Look::skip(1);
    if (b.size() < 2) return Look::need(2);
    const std::size_t length = 3 + 2 * std::size_t{b[1]};
    if (b[1] == 0 || length > kCapacity) return ++statistics.malformed, Look::skip(1);
    if (b.size() < length) return Look::need(length);
    examined_ += length;
    const unsigned sum = std::accumulate(b.begin(), b.begin() + long(length), 0U);
    if (sum % 256 != 0) return ++statistics.checksum_failures, Look::skip(1);
    return Look::frame(length);
  }
  template <class Sink>
  void deliver(Bytes b, std::uint64_t /*position*/, Sink& sink) {
    Message grams;
    for (std::size_t i = 2; i + 1 < b.size(); i += 2) grams.push_back(b[i] | b[i + 1] << 8);
    sink(grams);
  }
  [[nodiscard]] std::uint64_t examined() const { return examined_; }
  std::uint64_t examined_ = 0;
};

int main() {
  wayfare::Rng rng(1);
  std::vector<std::uint8_t> stream;
  for (int frame = 0; frame < 1000; ++frame) {
    for (auto n = rng.below(4); n > 0; --n) stream.push_back(std::uint8_t(rng.below(256)));
    std::vector<std::uint8_t> bytes{0x5A, 2, std::uint8_t(frame), std::uint8_t(frame >> 8), 7, 0};
    bytes.push_back(std::uint8_t(-std::accumulate(bytes.begin(), bytes.end(), 0)));
    if (frame % 100 == 99) bytes[3] ^= 0x10;  // damaged on the line
    stream.insert(stream.end(), bytes.begin(), bytes.end());
  }
  StreamDecoder<ScaleFraming> decoder;
  int right = 0, last = -1;
  const auto sink = [&](const std::vector<int>& grams) {
    right += grams.size() == 2 && grams[0] > last && grams[1] == 7 ? 1 : 0;
    last = grams[0];
  };
  for (Bytes rest(stream); !rest.empty(); rest = rest.subspan(std::min(rest.size(), 5UL)))
    decoder.feed(rest.first(std::min(rest.size(), 5UL)), sink);
  decoder.finish(sink);
  std::printf("%d of 990 undamaged frames, %zu checksum failures\n", right,
              std::size_t(decoder.statistics().checksum_failures));
}
