#pragma once

// The laws of a decoder, as checks on any decoder type:
//
//   DecoderLaws<TiDecoder> laws{stream, [](const auto& message) { return text_of(message); }};
//   laws.check();                                    // splits, garbage, bounded work
//   const DamageReport damage = laws.damage(10000);  // effect of cuts, flips and insertions
//
// A message has its position in the stream (`position()`) and its bytes (`bytes()`).

#include <algorithm>
#include <cmath>
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

namespace wayfare::testing {

/// The properties of a message that the laws compare.
struct SeenMessage {
  std::uint64_t position = 0;  ///< of its first byte in the stream
  std::uint64_t length = 0;    ///< bytes
  std::string text;            ///< its content without the position

  /// Equal in position, length and content.
  bool operator==(const SeenMessage&) const = default;
};

/// Results on damaged streams.
struct DamageReport {
  std::uint64_t streams = 0;       ///< damaged streams decoded
  std::uint64_t edits = 0;         ///< cuts, flips and insertions
  std::uint64_t damaged = 0;       ///< frames with bytes cut, changed or separated
  std::uint64_t undamaged = 0;     ///< the others
  std::uint64_t hidden = 0;        ///< undamaged ones not delivered, overlapped by a false frame
  std::uint64_t lost = 0;          ///< undamaged ones not delivered without such a reason
  std::uint64_t false_frames = 0;  ///< delivered, but different from those sent
  std::uint64_t refused = 0;       ///< complete frames with a wrong checksum

  /// Writes the counts to the test's properties (--gtest_output=xml:FILE).
  void record(const std::string& name) const {
    for (const auto& [what, n] : {std::pair{"streams", streams},
                                  {"edits", edits},
                                  {"damaged", damaged},
                                  {"undamaged", undamaged},
                                  {"hidden", hidden},
                                  {"lost", lost},
                                  {"false", false_frames},
                                  {"refused", refused}})
      ::testing::Test::RecordProperty(name + "_" + what, std::to_string(n));
  }

  /// Upper limit of false frames with a checksum that passes one in `strength`: the expected number
  /// of all it checked plus five standard deviations.
  [[nodiscard]] double most_false(double strength) const {
    const double expected = static_cast<double>(refused + false_frames) / strength;
    return expected + 5.0 * std::sqrt(expected) + 1.0;
  }
};

/// A damaged stream; `origin` is a byte's position in the undamaged one, or -1.
struct DamagedStream {
  std::vector<std::uint8_t> bytes;  ///< of the damaged stream
  std::vector<long> origin;         ///< of each byte
  std::uint64_t edits = 0;          ///< cuts, flips and insertions made
};

/// The stream with the origin of each byte.
[[nodiscard]] inline DamagedStream undamaged(const std::vector<std::uint8_t>& stream) {
  DamagedStream d{stream, std::vector<long>(stream.size()), 0};
  for (std::size_t i = 0; i < stream.size(); ++i) d.origin[i] = static_cast<long>(i);
  return d;
}

/// With one to `edits` random cuts, bit flips and insertions of 1 to 20 bytes.
[[nodiscard]] inline DamagedStream damaged(const std::vector<std::uint8_t>& stream, Rng& rng,
                                           int edits) {
  DamagedStream d = undamaged(stream);
  for (auto k = 1 + rng.below(edits); k > 0; --k) {
    ++d.edits;
    const auto at = static_cast<long>(rng.below(d.bytes.size()));
    const auto n = static_cast<long>(1 + rng.below(20));
    switch (rng.below(3)) {
      case 0: {
        const auto end = std::min(at + n, static_cast<long>(d.bytes.size()) - 1);
        d.bytes.erase(d.bytes.begin() + at, d.bytes.begin() + end);
        d.origin.erase(d.origin.begin() + at, d.origin.begin() + end);
        break;
      }
      case 1: {
        const auto i = static_cast<std::size_t>(at);
        d.bytes[i] = static_cast<std::uint8_t>(d.bytes[i] ^ (1U << rng.below(8)));
        d.origin[i] = -1;
        break;
      }
      default:
        for (long i = 0; i < n; ++i)
          d.bytes.insert(d.bytes.begin() + at, static_cast<std::uint8_t>(rng()));
        d.origin.insert(d.origin.begin() + at, static_cast<std::size_t>(n), -1);
    }
  }
  return d;
}

/// Position of the frame in the damaged stream, or -1 if it is damaged.
[[nodiscard]] inline long place(const SeenMessage& frame, const DamagedStream& d) {
  const auto first = static_cast<long>(frame.position);
  const auto at = std::find(d.origin.begin(), d.origin.end(), first);
  if (d.origin.end() - at < static_cast<long>(frame.length)) return -1;
  for (std::size_t i = 0; i < frame.length; ++i)
    if (*(at + static_cast<long>(i)) != first + static_cast<long>(i)) return -1;
  return at - d.origin.begin();
}

/// Adds the results on one damaged stream.
inline void judge(const std::vector<SeenMessage>& frames, const DamagedStream& d,
                  const std::vector<SeenMessage>& seen, DamageReport& report) {
  ++report.streams;
  report.edits += d.edits;
  std::vector<bool> true_frame(seen.size(), false);
  std::vector<std::uint64_t> missing;
  for (const SeenMessage& frame : frames) {
    const long at = place(frame, d);
    if (at < 0) {
      ++report.damaged;
      continue;
    }
    ++report.undamaged;
    const SeenMessage moved{static_cast<std::uint64_t>(at), frame.length, frame.text};
    const auto found = std::find(seen.begin(), seen.end(), moved);
    if (found == seen.end()) {
      missing.push_back(moved.position);
    } else {
      true_frame[static_cast<std::size_t>(found - seen.begin())] = true;
    }
  }
  for (const std::uint64_t at : missing) {
    bool hidden = false;
    for (std::size_t i = 0; i < seen.size(); ++i)
      hidden |= !true_frame[i] && seen[i].position <= at && at < seen[i].position + seen[i].length;
    ++(hidden ? report.hidden : report.lost);
  }
  report.false_frames +=
      static_cast<std::uint64_t>(std::count(true_frame.begin(), true_frame.end(), false));
}

/// Fails the current test where a decoder depends on the chunks of its stream, loses frames to
/// bytes
/// between them, or examines bytes without bound.
template <class Decoder>
struct DecoderLaws {
  /// A message in words.
  using Text = std::function<std::string(const typename Decoder::Message&)>;

  std::vector<std::uint8_t> stream;  ///< complete undamaged frames only
  Text text;                         ///< compared instead of messages
  /// A decoder that is ready for `stream`.
  std::function<std::unique_ptr<Decoder>()> make = [] { return std::make_unique<Decoder>(); };
  /// Upper limit of how often a byte is examined, for any input.
  double work_per_byte = 32.0;

  /// All laws on `stream`.
  void check() const {
    any_split_gives_the_same();
    garbage_costs_nothing();
    work_is_bounded();
  }

  using Seen = std::vector<SeenMessage>;  ///< in the order delivered

  /// The messages of a new decoder fed `bytes` in pieces of these lengths, the last one for the
  /// rest.
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
      for (int i = 0; i < 50; ++i) chunks.push_back(1 + rng.below(std::size_t{1} << rng.below(13)));
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
      const auto end =
          i + 1 < frames.size() ? static_cast<std::size_t>(frames[i + 1].position) : stream.size();
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
    nasty.emplace_back(100'000, *begin);
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
