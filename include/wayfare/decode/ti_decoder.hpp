#pragma once

// Frames from the data port of a TI mmWave sensor. The format has no checksum: a frame is accepted
// where its magic word, lengths, counts and end are consistent. And the chirp configuration (.cfg)
// of TI's demo with the resulting measurement limits.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/detail/bytes.hpp>
#include <wayfare/core/result.hpp>
#include <wayfare/decode/stream_decoder.hpp>
#include <wayfare/decode/ti_frame.hpp>

namespace wayfare::decode {

/// Before every frame.
inline constexpr std::array<std::uint8_t, 8> kTiMagic = {2, 1, 4, 3, 6, 5, 8, 7};

/// The first magic word at or after `from`, or `bytes.size()`. Its eight bytes are all different,
/// so that one byte determines the shift (Horspool 1980) and no byte is examined more than twice.
[[nodiscard]] inline std::size_t find_ti_magic(Bytes bytes, std::size_t from) {
  // Distance from byte value v in the word to its end; 8 where it is not part of the word.
  constexpr std::array<std::uint8_t, 9> kShift = {8, 6, 7, 4, 5, 2, 3, 8, 1};
  const std::uint64_t word = load_le<std::uint64_t>(kTiMagic.data());
  if (bytes.size() < 8) return bytes.size();
  const std::size_t last_start = bytes.size() - 8;
  std::size_t at = from;
  while (at <= last_start) {
    const std::uint8_t last = bytes[at + 7];
    if (last > 8) {
      at += 8;
    } else if (last != 7) {
      at += kShift[last];
    } else if (load_le<std::uint64_t>(&bytes[at]) == word) {
      return at;
    } else {
      at += 8;
    }
  }
  return bytes.size();
}

/// Framing of the data port. A frame ends where its header says, or at the next magic word where
/// that comes first (cut frames, and demos whose header counts too many bytes).
class TiFraming {
 public:
  using Message = TiFrame;                                        ///< of the sensor's data port
  static constexpr std::size_t kCapacity = std::size_t{1} << 16;  ///< longest frame

  /// What begins at the front of the stream.
  Look look(const Front& front, DecoderStatistics& statistics) {
    const Bytes b = front.bytes;
    if (front.position != start_) {
      start_ = front.position;
      scanned_ = 8;
    }
    const std::size_t magic = find_ti_magic(b.first(std::min<std::size_t>(b.size(), 8)), 0);
    if (magic != 0 || b.size() < 8) return seek(b);
    if (b.size() < kLeastHeader) return Look::need(kLeastHeader);
    const TiHeader header = read_header(b);
    if (!plausible(header)) {
      ++statistics.malformed;
      return Look::skip(8);
    }
    const std::size_t total = header.total_bytes, seen = std::min(b.size(), total);
    const std::size_t next = find_ti_magic(b.first(seen), scanned_);
    examined_ += next - scanned_;
    if (next == seen && seen < total) {
      scanned_ = std::max(scanned_, seen - 7);
      return Look::need(std::min(total, seen + kRescanStep));
    }
    return close(b.first(next), header, statistics);
  }

  /// Passes the frame to `sink(const TiFrame&)`.
  template <class Sink>
  void deliver(Bytes bytes, std::uint64_t position, Sink& sink) {
    frame_.position_ = position;
    frame_.bytes_ = bytes;
    sink(static_cast<const TiFrame&>(frame_));
  }

  /// Number of bytes inspected so far.
  [[nodiscard]] std::uint64_t examined() const { return examined_; }

 private:
  static constexpr std::size_t kLeastHeader = 36;
  static constexpr std::size_t kRescanStep = 256;  ///< bytes between searches for an early end

  /// No frame begins here: skips to the next magic word, or to what may be its beginning.
  Look seek(Bytes b) {
    const std::size_t magic = find_ti_magic(b, 0);
    examined_ += magic;
    if (magic < b.size()) return Look::skip(magic);
    return b.size() > 7 ? Look::skip(b.size() - 7) : Look::need(b.size() + 1);
  }

  static TiHeader read_header(Bytes b) {
    const auto word = [&](std::size_t at) { return load_le<std::uint32_t>(&b[at]); };
    return {word(8), word(12), word(16), word(20), word(24), word(28), word(32), 0};
  }

  static bool plausible(const TiHeader& h) {
    return h.total_bytes >= h.bytes() && h.total_bytes <= kCapacity &&
           h.tlvs <= h.total_bytes / 8 && h.points <= h.total_bytes / 12;
  }

  /// `b` is the whole frame. The search resumes in the last bytes of the items and the padding:
  /// where bytes of the frame were lost, the next magic word begins there.
  Look close(Bytes b, const TiHeader& header, DecoderStatistics& statistics) {
    const std::size_t used = parse(b, header);
    examined_ += b.size();
    if (used == 0) {
      ++statistics.malformed;
      return Look::skip(std::max<std::size_t>(8, b.size() - 7));
    }
    return {Look::Kind::frame, b.size(), std::max<std::size_t>(8, used - 7)};
  }

  /// Bytes used by header and items, 0 where the frame is inconsistent. Frames are padded to a
  /// multiple of 32 bytes.
  std::size_t parse(Bytes b, const TiHeader& header) {
    frame_ = {};
    frame_.header_ = header;
    std::size_t at = header.bytes();
    if (b.size() < at) return 0;
    if (at == 40) frame_.header_.subframe = load_le<std::uint32_t>(&b[36]);
    frame_.items_ = b.subspan(at);
    for (std::uint32_t i = 0; i < header.tlvs; ++i) {
      if (b.size() - at < 8) return 0;
      const std::size_t length = load_le<std::uint32_t>(&b[at + 4]);
      if (length > b.size() - at - 8) return 0;
      if (!take(load_le<std::uint32_t>(&b[at]), b.subspan(at + 8, length))) return 0;
      at += 8 + length;
    }
    if (frame_.points_ != header.points || b.size() - at >= 32) return 0;
    const bool side = frame_.side_info_.empty() || frame_.side_info_.size() == 4 * frame_.points_;
    return side ? at : 0;
  }

  bool take(std::uint32_t type, Bytes payload) {
    if (type == static_cast<std::uint32_t>(TiTlv::points)) return take_points(payload);
    if (type == static_cast<std::uint32_t>(TiTlv::side_info)) frame_.side_info_ = payload;
    return true;
  }

  bool take_points(Bytes payload) {
    if (frame_.header_.major() >= 3) {
      if (payload.size() % 16 != 0) return false;
      frame_.points_ = payload.size() / 16;
      frame_.coordinates_ = payload;
      return true;
    }
    if (payload.size() < 4) return false;
    frame_.points_ = load_le<std::uint16_t>(payload.data());
    const unsigned q = load_le<std::uint16_t>(&payload[2]);
    frame_.coordinates_ = payload.subspan(4);
    if (q > 15 || frame_.coordinates_.size() != 12 * frame_.points_) return false;
    frame_.fixed_point_scale_ = 1.0F / static_cast<float>(1U << q);
    return true;
  }

  TiFrame frame_;
  std::uint64_t examined_ = 0;
  std::uint64_t start_ = 0;  ///< of the candidate frame
  std::size_t scanned_ = 8;  ///< up to here it contains no other magic word
};

using TiDecoder = StreamDecoder<TiFraming>;  ///< of a byte stream to frames

/// Parameters of a chirp (`profileCfg`).
struct TiProfile {
  int id = 0;                     ///< of the profile
  double start_ghz = 0.0,         ///< start of the ramp
      idle_us = 0.0,              ///< before the ramp
      adc_start_us = 0.0,         ///< from the start of the ramp
      ramp_end_us = 0.0;          ///< likewise
  double slope_mhz_per_us = 0.0;  ///< of the ramp
  int samples = 0;                ///< ADC samples of a chirp
  double sample_ksps = 0.0;       ///< sampling rate
  double gain_db = 0.0;           ///< of the receivers
};

/// A run of chirps of one profile and one set of transmitters (`chirpCfg`).
struct TiChirp {
  int first = 0,         ///< index
      last = 0,          ///< index, included
      profile = 0;       ///< id of the profile
  unsigned tx_mask = 0;  ///< bit 0 TX1 …
};

/// Order and repetition of the chirps (`frameCfg`).
struct TiFrameTiming {
  int first_chirp = 0,     ///< index
      last_chirp = 0,      ///< index, included
      loops = 0;           ///< repetitions of the run in a frame
  int frames = 0;          ///< 0: until stopped
  double period_ms = 0.0;  ///< from frame to frame
};

/// A threshold detector over range (0) or Doppler (1) bins (`cfarCfg`).
struct TiCfar {
  bool on = false;         ///< used
  double threshold = 0.0;  ///< dB in SDK 3, a scale before
};

/// A checked configuration. The field-of-view limits are those applied by the firmware.
struct TiConfig {
  unsigned rx_mask = 0,                         ///< bit 0 RX1 …
      tx_mask = 0;                              ///< bit 0 TX1 …
  TiProfile profile;                            ///< the one the frame's chirps use
  std::vector<TiChirp> chirps;                  ///< in the order of the file
  TiFrameTiming frame;                          ///< order, repetition, period
  std::array<TiCfar, 2> cfar;                   ///< range, Doppler
  double min_range_m = 0.0,                     ///< `cfarFovCfg`; both 0: not given
      max_range_m = 0.0;                        ///< `cfarFovCfg`
  double min_speed_mps = 0.0,                   ///< `cfarFovCfg`; both 0: not given
      max_speed_mps = 0.0;                      ///< `cfarFovCfg`
  Angle min_azimuth = Angle::degrees(-90.0),    ///< `aoaFovCfg`
      max_azimuth = Angle::degrees(90.0);       ///< `aoaFovCfg`
  Angle min_elevation = Angle::degrees(-90.0),  ///< `aoaFovCfg`
      max_elevation = Angle::degrees(90.0);     ///< `aoaFovCfg`
  bool clutter_removal = false;                 ///< points at rest are removed
  bool extended_velocity = false;               ///< speeds are unwrapped by the firmware
  /// Commands that are irrelevant here or unknown, verbatim.
  std::vector<std::string> others;
};

/// Reads the text of a .cfg file; `source` names it in messages. Errors: a malformed or missing
/// command (by line), values outside the chip's range or inconsistent, advanced frames.
[[nodiscard]] Result<TiConfig> parse_ti_config(std::string_view text, const std::string& source);

/// The grid of the firmware's points, and their limits.
struct TiLimits {
  double centre_hz = 0.0;           ///< mean frequency while the ADC samples
  double bandwidth_hz = 0.0;        ///< swept while the ADC samples
  int transmitters = 0;             ///< in time-division multiplexing
  int range_bins = 0;               ///< of the range transform
  int doppler_bins = 0;             ///< of the Doppler transform
  int azimuth_antennas = 0;         ///< virtual antennas in the horizontal row
  double range_step_m = 0.0;        ///< between range bins
  double range_resolution_m = 0.0;  ///< points closer together are not separated
  double max_range_m = 0.0;         ///< last range bin, or the firmware's limit
  double speed_step_mps = 0.0;      ///< between Doppler bins: also the resolution
  double max_speed_mps = 0.0;       ///< beyond ± this, speed is ambiguous
  Angle azimuth_resolution;         ///< straight ahead
  double sin_azimuth_step = 0.0;    ///< between bins of the angle transform
};

/// The chip ramps at whole multiples of 900 · 3.6e9 / 2^26 Hz/µs (2.7e9 in the 60 GHz band) and
/// rounds a slope down to one (TI, mmWaveLink interface, rlProfileCfg); range and speed grids are
/// computed from that. Speeds use the centre of the sampled window, not the start of the ramp: for
/// a 3.4 GHz sweep at 77 GHz that is 2.8 %. `config` is one that `parse_ti_config` returns. Speed
/// of light as in the firmware, 3·10⁸ m/s, which determines the grid of its points.
[[nodiscard]] TiLimits limits_of(const TiConfig& config);

}  // namespace wayfare::decode
