// Random sequences of calls on decoders and on what follows them, each compared with a simple
// model: a new decoder that is fed each stream at once, a sorted map, a vector.
#include <algorithm>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/decode/awinda.hpp>
#include <wayfare/decode/rplidar_scan.hpp>
#include <wayfare/decode/stream_decoder.hpp>

#include "abuse/decode_streams.hpp"

namespace wayfare::decode {
namespace {

using tests::Stream;

/// Cuts, flips, insertions, parts repeated.
void damage(Stream& bytes, Rng& rng) {
  for (auto edits = rng.below(5); edits > 0 && bytes.size() > 40; --edits) {
    const auto at = static_cast<long>(rng.below(bytes.size() - 30));
    const auto n = static_cast<long>(1 + rng.below(30));
    switch (rng.below(4)) {
      case 0:
        bytes.erase(bytes.begin() + at, bytes.begin() + at + n);
        break;
      case 1:
        bytes[static_cast<std::size_t>(at)] ^= static_cast<std::uint8_t>(1U << rng.below(8));
        break;
      case 2:
        bytes.insert(bytes.begin() + at, static_cast<std::size_t>(n),
                     static_cast<std::uint8_t>(rng()));
        break;
      default: {
        const Stream part(bytes.begin() + at, bytes.begin() + at + n);
        bytes.insert(bytes.begin() + static_cast<long>(rng.below(bytes.size())), part.begin(),
                     part.end());
      }
    }
  }
}

DecoderStatistics sum(const DecoderStatistics& a, const DecoderStatistics& b) {
  return {a.bytes + b.bytes, a.frames + b.frames, a.skipped_bytes + b.skipped_bytes,
          a.checksum_failures + b.checksum_failures, a.malformed + b.malformed};
}

/// Streams in random chunks through one decoder, which is ended between them, and copied, moved and
/// assigned anywhere. Adds the messages to `messages`.
template <class Device>
void run_decoder_schedule(const Device& device, std::uint64_t seed, std::uint64_t& messages) {
  Rng rng(seed);
  auto decoder = device.fresh();
  using Decoder = std::decay_t<decltype(*decoder)>;
  DecoderStatistics expected_counts;
  std::string calls;
  for (auto streams = 1 + rng.below(4); streams > 0; --streams) {
    const auto first = rng.below(device.stream.size() / 2);
    Stream bytes(device.stream.begin() + static_cast<long>(first), device.stream.end());
    bytes.resize(rng.below(bytes.size() + 1));
    damage(bytes, rng);

    const auto model = device.fresh();
    std::vector<std::string> expected, seen;
    const auto note = [&](const auto& m) { expected.push_back(tests::seen_text(m)); };
    model->feed(bytes, note);
    model->finish(note);

    const std::uint64_t origin = expected_counts.bytes;
    const auto sink = [&](const auto& m) { seen.push_back(tests::seen_text(m, origin)); };
    for (std::size_t at = 0; at < bytes.size();) {
      const std::size_t n =
          std::min(bytes.size() - at, static_cast<std::size_t>(rng.below(1U << rng.below(11))));
      // A copy of its own, so that a sanitizer sees a read past it or after it.
      const Stream piece(bytes.begin() + static_cast<long>(at),
                         bytes.begin() + static_cast<long>(at + n));
      calls += " feed " + std::to_string(n);
      decoder->feed(piece, sink);
      at += n;
      if (rng.below(8) != 0) continue;
      calls += " copy";
      auto copy = std::make_unique<Decoder>(*decoder);
      if (rng.below(2) == 0) {
        auto assigned = device.fresh();
        assigned->feed(Bytes(device.stream).first(50), [](const auto&) {});
        *assigned = std::move(*copy);
        copy = std::move(assigned);
      }
      decoder->feed(Stream(rng.below(300), static_cast<std::uint8_t>(rng())), [](const auto&) {});
      decoder = std::move(copy);  // the source, which went another way, is destroyed
    }
    calls += " finish";
    decoder->finish(sink);
    expected_counts = sum(expected_counts, model->statistics());
    SCOPED_TRACE(std::string(device.name) + ", seed " + std::to_string(seed) + ":" + calls);
    ASSERT_EQ(seen, expected);
    ASSERT_EQ(decoder->statistics(), expected_counts);
    ASSERT_EQ(decoder->held(), 0U);
    messages += seen.size();
  }
}

TEST(DecodeSequences, AnyScheduleDecodesAsOneCall) {
  tests::for_every_decoder([](const auto& device) {
    std::uint64_t messages = 0;
    for (std::uint64_t seed = 0; seed < 400 && !::testing::Test::HasFatalFailure(); ++seed)
      run_decoder_schedule(device, seed, messages);
    EXPECT_GT(messages, 1000U);
  });
}

// ---- Awinda ----

/// The rule of the reorder buffer, on a map.
struct SortedFrames {
  std::int64_t window;
  std::map<std::int64_t, bool> buffered = {};  ///< by frame, counted on without wrapping
  std::int64_t next = 0;
  bool started = false;
  std::uint64_t late = 0, missing = 0;
  std::vector<std::uint32_t> delivered = {};

  void deliver(std::int64_t frame) { delivered.push_back(static_cast<std::uint32_t>(frame)); }
  void add(std::uint32_t frame, bool retransmitted) {
    if (!std::exchange(started, true)) next = frame;
    const std::int64_t ahead = static_cast<std::int32_t>(frame - static_cast<std::uint32_t>(next));
    if (ahead >= 2 * window || (ahead <= -2 * window && !retransmitted)) {
      finish();
      started = true;
      next = frame;
      buffered[next] = true;
    } else if (ahead < 0 || !buffered.emplace(next + ahead, true).second) {
      ++late;
      return;
    }
    const std::int64_t newest = buffered.rbegin()->first;
    for (; buffered.contains(next) || newest - next >= window; ++next) {
      if (buffered.erase(next) != 0) {
        deliver(next);
      } else {
        ++missing;
      }
    }
  }
  void finish() {
    for (const auto& [frame, present] : buffered) deliver(frame);
    buffered.clear();
    started = false;
  }
};

TEST(DecodeSequences, TheReorderBufferSortsAsAMapDoes) {
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    Rng rng(seed);
    AwindaReorderBuffer<8> order;
    SortedFrames model{8};
    std::vector<std::uint32_t> seen;
    const auto sink = [&](const AwindaSnapshot& s) { seen.push_back(s.frame); };
    std::uint32_t frame = static_cast<std::uint32_t>(rng()) | (seed % 2 == 0 ? 0xFFFFFF00U : 0U);
    std::string calls;
    for (int i = 0; i < 200; ++i) {
      const auto kind = rng.below(40);
      if (kind == 0) {
        calls += " finish";
        order.finish(sink);
        model.finish();
        continue;
      }
      AwindaSnapshot s;
      s.frame = frame + static_cast<std::uint32_t>(rng.below(12)) - 6;
      s.retransmitted = rng.below(4) == 0;
      if (kind == 1) s.frame ^= 1U << rng.below(32);
      if (kind > 10) ++frame;
      calls += " " + std::to_string(s.frame) + (s.retransmitted ? "r" : "");
      order.add(s, sink);
      model.add(s.frame, s.retransmitted);
      if (rng.below(20) == 0) {
        const AwindaReorderBuffer<8> copy = order;
        order = copy;
      }
      SCOPED_TRACE("seed " + std::to_string(seed) + ":" + calls);
      ASSERT_EQ(seen, model.delivered);
      ASSERT_EQ(order.late(), model.late);
      ASSERT_EQ(order.missing(), model.missing);
    }
  }
}

// ---- revolutions ----

TEST(DecodeSequences, RevolutionsAreTheRunsBetweenStarts) {
  constexpr std::size_t kMost = 20;
  using Run = std::pair<std::vector<std::uint32_t>, bool>;
  for (std::uint64_t seed = 0; seed < 500; ++seed) {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    RplidarRevolutions<kMost> revolutions;
    std::vector<Run> seen, expected;
    Run run{{}, false};
    std::uint64_t dropped = 0;
    const auto sink = [&](const RplidarRevolution& r) {
      seen.push_back({{}, r.whole});
      for (const TimedRplidarPoint& p : r.points) seen.back().first.push_back(p.point.distance_q2);
    };
    const auto end_run = [&](bool whole_after) {
      if (!run.first.empty()) expected.push_back(run);
      run = {{}, whole_after};
    };
    std::uint32_t number = 0;
    for (int call = 0; call < 60; ++call) {
      if (rng.below(15) == 0) {
        run.second = false;
        end_run(false);
        revolutions.finish(sink);
        continue;
      }
      std::vector<RplidarPoint> points(rng.below(12));
      for (RplidarPoint& p : points) {
        p = {0, number++, 0, rng.below(14) == 0};
        if (p.start_of_revolution) end_run(true);
        if (run.first.size() < kMost) {
          run.first.push_back(p.distance_q2);
        } else {
          ++dropped;
          run.second = false;
        }
      }
      revolutions.add(points, LogTime{}, Duration(1), sink);
    }
    ASSERT_EQ(seen, expected);
    ASSERT_EQ(revolutions.dropped_points(), dropped);
  }
}

}  // namespace
}  // namespace wayfare::decode
