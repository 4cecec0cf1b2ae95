// Stream decoders at the edges: no bytes, cut streams, copies, threads, mistaken framings.
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/decode/stream_decoder.hpp>
#include <wayfare/decode/xbus.hpp>

#include "abuse/abuse.hpp"
#include "abuse/decode_streams.hpp"

namespace wayfare::decode {
namespace {

using tests::in_two_threads;
using tests::seen_text;
using tests::Stream;

TEST(DecodeAbuse, NoBytesAreNoMessage) {
  tests::for_every_decoder([](const auto& device) {
    auto decoder = device.fresh();
    const auto fail = [](const auto&) { FAIL() << "no message without bytes"; };
    for (int i = 0; i < 3; ++i) {
      decoder->feed({}, fail);
      decoder->finish(fail);
    }
    EXPECT_EQ(decoder->statistics(), DecoderStatistics{});
    EXPECT_EQ(decoder->held(), 0U);
  });
}

TEST(DecodeAbuse, EveryPrefixOfAStreamEnds) {
  tests::for_every_decoder([](const auto& device) {
    const std::size_t end = std::min<std::size_t>(device.stream.size(), 700);
    for (std::size_t n = 0; n <= end; ++n) {
      auto decoder = device.fresh();
      const Stream prefix(device.stream.begin(), device.stream.begin() + static_cast<long>(n));
      std::uint64_t in_frames = 0;
      const auto sink = [&](const auto& m) {
        in_frames += m.bytes().size();
        ASSERT_LE(m.position() + m.bytes().size(), n);
      };
      decoder->feed(prefix, sink);
      decoder->finish(sink);
      ASSERT_EQ(decoder->held(), 0U);
      ASSERT_EQ(decoder->statistics().bytes, n);
      ASSERT_LE(decoder->statistics().skipped_bytes, n);
      ASSERT_GE(decoder->statistics().skipped_bytes + in_frames, n) << "every byte is accounted";
    }
  });
}

TEST(DecodeAbuse, DecodersAreValues) {
  tests::for_every_decoder([](const auto& device) {
    auto middle = device.fresh();
    const std::size_t half = device.stream.size() / 2 + 3;  // inside a frame
    middle->feed(Bytes(device.stream).first(half), [](const auto&) {});
    using Decoder = std::decay_t<decltype(*middle)>;
    // On the heap: decoders have large buffers, and expect_value_semantics() would have five.
    const auto rest = [&](Decoder& decoder) {
      std::string text;
      const auto sink = [&](const auto& m) { text += seen_text(m); };
      decoder.feed(Bytes(device.stream).subspan(half), sink);
      decoder.finish(sink);
      return text;
    };
    const auto copy = std::make_unique<Decoder>(*middle), second = std::make_unique<Decoder>();
    const auto moved = std::make_unique<Decoder>(std::move(*std::make_unique<Decoder>(*middle)));
    *second = *middle;
    Decoder& same = *second;
    *second = same;
    const std::string expected = rest(*copy);
    EXPECT_NE(expected, "");
    EXPECT_EQ(rest(*second), expected);
    EXPECT_EQ(rest(*moved), expected);
    EXPECT_EQ(rest(*middle), expected) << "the source changed with its copies";
    EXPECT_EQ(middle->statistics(), copy->statistics());
  });
}

TEST(DecodeAbuse, TwoDecodersInTwoThreads) {
  tests::for_every_decoder([](const auto& device) {
    const auto both = in_two_threads([&](int) {
      auto decoder = device.fresh();
      std::string text;
      const auto sink = [&](const auto& m) { text += seen_text(m); };
      for (std::size_t at = 0; at < device.stream.size(); at += 61)
        decoder->feed(
            Bytes(device.stream).subspan(at, std::min<std::size_t>(61, device.stream.size() - at)),
            sink);
      decoder->finish(sink);
      return text;
    });
    EXPECT_EQ(both[0], both[1]);
    EXPECT_NE(both[0], "");
  });
}

TEST(DecodeAbuse, AMessageOutlivesNothingButItsBytesMayBeFedToAnother) {
  tests::for_every_decoder([](const auto& device) {
    auto first = device.fresh(), second = device.fresh();
    std::string direct, passed;
    const auto keep = [&](const auto& m) { passed += m.bytes().empty() ? "" : "x"; };
    const auto sink = [&](const auto& m) {
      direct += "x";
      second->feed(m.bytes(), keep);
    };
    first->feed(device.stream, sink);
    first->finish(sink);
    second->finish(keep);
    EXPECT_GT(direct.size(), 0U);
    EXPECT_GE(passed.size() + 1, direct.size());
  });
}

// ---- framings ----

/// A framing of a stranger, with a mistake.
struct MistakenFraming {
  struct Message {};
  static constexpr std::size_t kCapacity = 8;
  static inline Look answer = Look::need(1);
  Look look(const Front&, DecoderStatistics&) { return answer; }
  template <class Sink>
  void deliver(Bytes, std::uint64_t, Sink& sink) {
    sink(Message{});
  }
  [[nodiscard]] std::uint64_t examined() const { return 0; }
};

TEST(DecodeAbuseDeathTest, AMistakenFramingIsReported) {
  const Stream bytes(4);
  for (const Look look : {Look::need(4), Look::need(0), Look::need(9), Look::skip(0), Look::skip(5),
                          Look{Look::Kind::frame, 4, 0}, Look{Look::Kind::frame, 4, 5}}) {
    EXPECT_DEATH(
        {
          MistakenFraming::answer = look;
          StreamDecoder<MistakenFraming> decoder;
          decoder.feed(bytes, [](const auto&) {});
        },
        "a framing");
  }
}

TEST(DecodeAbuseDeathTest, ALineHasAPositiveRate) {
  EXPECT_DEATH(static_cast<void>(line_time(1, 0)), "rate of a line");
  EXPECT_DEATH(static_cast<void>(line_time(0, -9600)), "rate of a line");
  EXPECT_EQ(line_time(std::numeric_limits<std::uint64_t>::max(), 1), Duration::max());
}

TEST(XbusAbuse, AShortMessageMayBeLongerThanTheLimit) {
  // 200 bytes of data fit the short form, but not a buffer for messages of at most 16.
  const Stream bytes = tests::xbus_message(0x36, Stream(200, 1));
  Stream all = bytes;
  all.insert(all.end(), 300, 0);
  const Stream good = tests::xbus_message(0x36, Stream(16, 2));
  all.insert(all.end(), good.begin(), good.end());
  StreamDecoder<BasicXbusFraming<16>> decoder;
  std::vector<std::size_t> lengths;
  const auto sink = [&](const XbusMessage& m) { lengths.push_back(m.data().size()); };
  for (const std::uint8_t& byte : all) decoder.feed({&byte, 1}, sink);
  decoder.finish(sink);
  EXPECT_EQ(lengths, std::vector<std::size_t>{16});
  EXPECT_GE(decoder.statistics().malformed, 1U);
  EXPECT_EQ(decoder.statistics().skipped_bytes, all.size() - good.size());
}

TEST(XbusAbuse, MessagesToWrite) {
  std::vector<std::uint8_t> out(70'000);
  for (const std::size_t n : {0U, 1U, 254U, 255U, 65535U}) {
    const Stream data(n, 0xFA);
    const std::size_t length = write_xbus(0xFF, XbusId::mt_data2, data, out);
    ASSERT_EQ(length, n + (n < 255 ? 5 : 7));
    EXPECT_EQ(byte_sum(Bytes(out).subspan(1, length - 1)), 0);
    EXPECT_EQ(write_xbus(0xFF, XbusId::mt_data2, data, std::span(out).first(length - 1)), 0U);
  }
  EXPECT_EQ(write_xbus(0xFF, XbusId::mt_data2, Stream(65536), out), 0U);
  EXPECT_EQ(write_xbus(0xFF, XbusId::mt_data2, {}, {}), 0U);
  EXPECT_EQ(byte_sum({}), 0);
}

}  // namespace
}  // namespace wayfare::decode
