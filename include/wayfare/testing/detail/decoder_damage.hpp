#pragma once

// Streams of frames with known damage, and a decoder's results on them.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>

namespace wayfare::testing {

/// The properties of a message that the laws compare.
struct SeenMessage {
  std::uint64_t position = 0;
  std::uint64_t length = 0;
  std::string text;  ///< its content without the position

  bool operator==(const SeenMessage&) const = default;
};

/// Results on damaged streams.
struct DamageReport {
  std::uint64_t streams = 0;
  std::uint64_t edits = 0;         ///< cuts, flips and insertions
  std::uint64_t damaged = 0;       ///< frames with bytes cut, changed or separated
  std::uint64_t undamaged = 0;     ///< the others
  std::uint64_t hidden = 0;        ///< undamaged ones not delivered, overlapped by a false frame
  std::uint64_t lost = 0;          ///< undamaged ones not delivered without such a reason
  std::uint64_t false_frames = 0;  ///< delivered, but different from those sent
  std::uint64_t refused = 0;       ///< complete frames with a wrong checksum

  /// Writes the counts to the test's properties (--gtest_output=xml:FILE).
  void record(const std::string& name) const {
    const auto write = [&](const char* what, std::uint64_t n) {
      ::testing::Test::RecordProperty(name + "_" + what, std::to_string(n));
    };
    write("streams", streams);
    write("edits", edits);
    write("damaged", damaged);
    write("undamaged", undamaged);
    write("hidden", hidden);
    write("lost", lost);
    write("false", false_frames);
    write("refused", refused);
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
  std::vector<std::uint8_t> bytes;
  std::vector<long> origin;
  std::uint64_t edits = 0;
};

[[nodiscard]] inline DamagedStream undamaged(const std::vector<std::uint8_t>& stream) {
  DamagedStream d{stream, std::vector<long>(stream.size()), 0};
  for (std::size_t i = 0; i < stream.size(); ++i) d.origin[i] = static_cast<long>(i);
  return d;
}

[[nodiscard]] inline DamagedStream damaged(const std::vector<std::uint8_t>& stream, Rng& rng,
                                           int edits) {
  DamagedStream d = undamaged(stream);
  for (auto k = 1 + rng.below(static_cast<std::uint64_t>(edits)); k > 0; --k) {
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

}  // namespace wayfare::testing
