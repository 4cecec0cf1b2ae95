// A framing of a protocol that the library does not know, by the laws of decoders.
#include <wayfare/decode/stream_decoder.hpp>

#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/testing/decoder_laws.hpp>

namespace wayfare::decode {
namespace {

struct Reading {
  Bytes frame;
  std::uint64_t at = 0;
  [[nodiscard]] Bytes bytes() const { return frame; }
  [[nodiscard]] std::uint64_t position() const { return at; }
};

/// 0x5A, a number of bytes from 1 to 40, these bytes, and a byte that makes the sum of all zero.
struct SumFraming {
  using Message = Reading;
  static constexpr std::size_t kCapacity = 43;
  Look look(const Front& front, DecoderStatistics& statistics) {
    const Bytes b = front.bytes;
    ++examined_bytes;
    if (b[0] != 0x5A) return Look::skip(1);
    if (b.size() < 2) return Look::need(2);
    const std::size_t length = 3 + std::size_t{b[1]};
    if (b[1] == 0 || length > kCapacity) {
      ++statistics.malformed;
      return Look::skip(1);
    }
    if (b.size() < length) return Look::need(length);
    examined_bytes += length;
    const Bytes frame = b.first(length);
    if (std::accumulate(frame.begin(), frame.end(), 0U) % 256 == 0) return Look::frame(length);
    ++statistics.checksum_failures;
    return Look::skip(1);
  }
  template <class Sink>
  void deliver(Bytes bytes, std::uint64_t position, Sink& sink) {
    sink(Reading{bytes, position});
  }
  [[nodiscard]] std::uint64_t examined() const { return examined_bytes; }
  std::uint64_t examined_bytes = 0;
};

static_assert(Framing<SumFraming>);

TEST(OwnFraming, SatisfiesTheLawsOfDecoders) {
  Rng rng(1);
  std::vector<std::uint8_t> stream;
  for (int i = 0; i < 40; ++i) {
    std::vector<std::uint8_t> frame{0x5A, static_cast<std::uint8_t>(1 + rng.below(40))};
    for (int k = frame[1]; k > 0; --k) frame.push_back(static_cast<std::uint8_t>(rng()));
    frame.push_back(
        static_cast<std::uint8_t>(256U - std::accumulate(frame.begin(), frame.end(), 0U) % 256U));
    stream.insert(stream.end(), frame.begin(), frame.end());
  }
  testing::DecoderLaws<StreamDecoder<SumFraming>> laws{
      stream, [](const Reading& r) { return std::string(r.frame.begin(), r.frame.end()); }};
  laws.work_per_byte = 1.0 + SumFraming::kCapacity;
  laws.check();
  const testing::DamageReport report = laws.damage(1000);
  EXPECT_EQ(report.lost, 0U);
  EXPECT_LE(static_cast<double>(report.false_frames), report.most_false(256.0));
}

}  // namespace
}  // namespace wayfare::decode
