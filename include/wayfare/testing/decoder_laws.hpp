#pragma once

// The laws of a decoder, as checks on any decoder type:
//
//   DecoderLaws<TiDecoder> laws{stream, [](const auto& message) { return text_of(message); }};
//   laws.check();                                    // splits, garbage, bounded work
//   const DamageReport damage = laws.damage(10000);  // effect of cuts, flips and insertions
//
// A message has its position in the stream (`position()`) and its bytes (`bytes()`).

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/decode/stream_decoder.hpp>
#include <wayfare/testing/detail/decoder_damage.hpp>

namespace wayfare::testing {

template <class Decoder>
struct DecoderLaws {
  using Text = std::function<std::string(const typename Decoder::Message&)>;

  std::vector<std::uint8_t> stream;  ///< complete undamaged frames only
  Text text;
  /// A decoder that is ready for `stream`.
  std::function<std::unique_ptr<Decoder>()> make = [] { return std::make_unique<Decoder>(); };
  /// Upper limit of how often a byte is examined, for any input.
  double work_per_byte = 32.0;

  void check() const {
    any_split_gives_the_same();
    garbage_costs_nothing();
    work_is_bounded();
  }

  using Seen = std::vector<SeenMessage>;

  [[nodiscard]] Seen decode(const std::vector<std::uint8_t>& bytes,
                            const std::vector<std::size_t>& chunks = {},
                            decode::DecoderStatistics* statistics = nullptr) const {
    const auto decoder = make();
    Seen seen;
    const auto sink = [&](const typename Decoder::Message& m) {
      seen.push_back({m.position(), m.bytes().size(), text(m)});
    };
    std::size_t at = 0, chunk = 0;
    while (at < bytes.size()) {
      const std::size_t wanted = chunks.empty() ? bytes.size() : chunks[chunk++ % chunks.size()];
      const std::size_t n = std::min(wanted, bytes.size() - at);
      // A copy of its own, so that a sanitizer sees a read past it.
      const std::vector<std::uint8_t> piece(bytes.begin() + static_cast<long>(at),
                                            bytes.begin() + static_cast<long>(at + n));
      decoder->feed(piece, sink);
      at += n;
    }
    decoder->finish(sink);
    if (statistics != nullptr) *statistics = decoder->statistics();
    return seen;
  }

  /// For any split of the bytes, with damage or without: the same messages and the same counts.
  void any_split_gives_the_same() const {
    Rng rng(11);
    for (int trial = 0; trial < 40; ++trial) {
      const DamagedStream d = trial == 0 ? undamaged(stream) : damaged(stream, rng, 3);
      decode::DecoderStatistics expected, counted;
      const Seen messages = decode(d.bytes, {}, &expected);
      EXPECT_TRUE(trial != 0 || messages.size() > 2) << "the stream has too few frames";
      std::vector<std::size_t> chunks;
      for (int i = 0; i < 50; ++i)
        chunks.push_back(1 + rng.below(std::uint64_t{1} << rng.below(13)));
      for (const auto& split : {std::vector<std::size_t>{1}, {7}, chunks}) {
        const Seen seen = decode(d.bytes, split, &counted);
        EXPECT_TRUE(seen == messages) << "trial " << trial << ": " << seen.size() << " messages, "
                                      << messages.size() << " in one piece";
        EXPECT_TRUE(counted == expected) << "other counts in trial " << trial;
      }
    }
  }

  /// Bytes between frames that cannot begin one lose no frame, and all of them are counted.
  void garbage_costs_nothing(std::uint8_t garbage = 0) const {
    const Seen frames = decode(stream);
    std::vector<std::uint8_t> bytes;
    std::size_t at = 0, inserted = 0;
    for (std::size_t i = 0; i < frames.size(); ++i) {
      const std::size_t n = 1 + 37 * i % 101;
      bytes.insert(bytes.end(), n, garbage);
      inserted += n;
      const std::size_t end = i + 1 < frames.size() ? frames[i + 1].position : stream.size();
      bytes.insert(bytes.end(), stream.begin() + static_cast<long>(at),
                   stream.begin() + static_cast<long>(end));
      at = end;
    }
    decode::DecoderStatistics statistics;
    const Seen seen = decode(bytes, {}, &statistics);
    ASSERT_EQ(seen.size(), frames.size());
    for (std::size_t i = 0; i < seen.size(); ++i) EXPECT_EQ(seen[i].text, frames[i].text);
    EXPECT_EQ(statistics.skipped_bytes, inserted);
  }

  /// For any input and any chunks, a byte is examined at most a fixed number of times.
  void work_is_bounded() const {
    Rng rng(12);
    std::vector<std::vector<std::uint8_t>> nasty;
    const Seen frames = decode(stream);
    const auto begin = stream.begin() + static_cast<long>(frames.at(0).position);
    for (const std::size_t prefix : {1U, 2U, 4U, 5U, 8U, 16U, 40U}) {  // incomplete frames
      std::vector<std::uint8_t> bytes;
      while (bytes.size() < 100'000)
        bytes.insert(bytes.end(), begin, begin + static_cast<long>(prefix));
      nasty.push_back(std::move(bytes));
    }
    nasty.emplace_back(100'000, stream[frames.at(0).position]);
    nasty.emplace_back(100'000);
    for (auto& byte : nasty.back()) byte = static_cast<std::uint8_t>(rng());
    for (const auto& bytes : nasty) {
      for (const std::size_t chunk : {std::size_t{1}, std::size_t{64}, bytes.size()}) {
        const auto decoder = make();
        const auto sink = [](const auto&) {};
        for (std::size_t at = 0; at < bytes.size(); at += chunk)
          decoder->feed(decode::Bytes(bytes).subspan(at, std::min(chunk, bytes.size() - at)), sink);
        decoder->finish(sink);
        const auto n = static_cast<double>(bytes.size());
        const decode::DecoderWork work = decoder->work();
        EXPECT_LE(static_cast<double>(work.looks), 2.0 * n + 2.0) << "chunks of " << chunk;
        EXPECT_LE(static_cast<double>(work.examined), work_per_byte * n + 100.0)
            << "chunks of " << chunk;
      }
    }
  }

  /// Cuts, flips and inserts bytes, one to `edits` times per stream.
  [[nodiscard]] DamageReport damage(int streams, int edits = 3, std::uint64_t seed = 1) const {
    Rng rng(seed);
    DamageReport report;
    const Seen frames = decode(stream);
    for (int i = 0; i < streams; ++i) {
      const DamagedStream d = damaged(stream, rng, edits);
      decode::DecoderStatistics statistics;
      const Seen seen = decode(d.bytes, {}, &statistics);
      report.refused += statistics.checksum_failures;
      judge(frames, d, seen, report);
    }
    return report;
  }
};

}  // namespace wayfare::testing
