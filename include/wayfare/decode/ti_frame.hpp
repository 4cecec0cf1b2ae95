#pragma once

// One frame of a TI mmWave sensor's data port (out-of-box demo of the mmWave SDK 1.x to 5.x, people
// counting, area scanner): header, type-length-value items, padding. All little endian. Layouts:
// TI, mmw_output.h and detected_obj.h of SDK 1.2, mmw_output.h of SDK 3.6, pcount3D_output.h and
// user's guides of the mmWave Industrial Toolbox 4.7. And its conversion to a RadarScan and a time.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include <wayfare/core/detail/bytes.hpp>
#include <wayfare/core/detail/eigen_alignment.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/decode/ti_header.hpp>
#include <wayfare/sensors/scans.hpp>

namespace wayfare::decode {

/// A detected point: x right, y forward (boresight), z up.
struct TiPoint {
  static constexpr float kNone = std::numeric_limits<float>::quiet_NaN();  ///< not measured

  float x_m = 0.0F,              ///< right
      y_m = 0.0F,                ///< forward
      z_m = 0.0F;                ///< up
  float doppler_mps = kNone;     ///< positive moving away; before SDK 3 only its bin is sent
  std::int16_t snr_ddb = 0;      ///< tenths of dB, where the frame has side information
  std::int16_t noise_ddb = 0;    ///< likewise
  std::uint16_t range_bin = 0;   ///< before SDK 3
  std::int16_t doppler_bin = 0;  ///< before SDK 3
  std::uint16_t peak = 0;        ///< before SDK 3; of compressed points the strength as sent
};

/// Encodings of points.
enum class TiPoints : std::uint8_t {
  fixed,       ///< bins, peak and coordinates as 16-bit numbers, before SDK 3
  cartesian,   ///< coordinates and speed as floats
  spherical,   ///< range, azimuth, elevation and speed as floats
  polar,       ///< range, azimuth, speed and strength as floats
  compressed,  ///< elevation, azimuth, speed, range and strength in units of 20 bytes before them
  packed,      ///< coordinates, speed, strength and noise in units of 20 bytes before them
};

/// Timing and load of the sensor (TLV 6).
struct TiStatistics {
  std::uint32_t processing_us = 0,        ///< of the frame
      transmit_us = 0,                    ///< of the data
      frame_margin_us = 0,                ///< left in the frame
      chirp_margin_us = 0;                ///< left in a chirp
  std::uint32_t active_load_percent = 0,  ///< of the processor in chirps
      idle_load_percent = 0;              ///< of the processor between frames
};

/// Chip temperatures (TLV 9), °C: receivers 0…3, transmitters 0…2, power management, digital 0, 1.
struct TiTemperature {
  bool valid = false;             ///< as the sensor reports
  std::uint32_t time_ms = 0;      ///< since its start
  std::int16_t celsius[10] = {};  ///< as above
};

/// A checked frame. It refers to the decoder's bytes: copy what must outlive the sink.
class TiFrame {
 public:
  TiFrame() = default;

  /// The frame's header.
  [[nodiscard]] const TiHeader& header() const { return header_; }
  [[nodiscard]] std::uint64_t position() const { return position_; }  ///< of its magic word
  [[nodiscard]] Bytes bytes() const { return bytes_; }                ///< all of it
  /// Number of points.
  [[nodiscard]] std::size_t size() const { return points_; }
  /// Point i < size().
  [[nodiscard]] TiPoint operator[](std::size_t i) const;
  /// Whether points have a strength and noise.
  [[nodiscard]] bool has_side_info() const { return !side_info_.empty(); }
  /// Whether points have a strength: as side information, or in themselves.
  [[nodiscard]] bool has_strength() const {
    return has_side_info() || encoding_ > TiPoints::spherical;
  }
  /// Whether points have a noise.
  [[nodiscard]] bool has_noise() const { return has_side_info() || encoding_ == TiPoints::packed; }
  /// How its points are sent.
  [[nodiscard]] TiPoints encoding() const { return encoding_; }

  /// The payload of the first item of a type; empty where there is none.
  [[nodiscard]] Bytes find(TiTlv type) const;
  /// Calls `f(std::uint32_t type, Bytes payload)` for every item, known or not, in order.
  template <class F>
  void for_each(F&& f) const {
    const std::uint8_t* p = items_.data();
    const std::size_t counted = header_.counts_item_heads() ? 8 : 0;
    for (std::uint32_t i = 0; i < header_.tlvs; ++i) {
      const std::size_t length = load_le<std::uint32_t>(p + 4) - counted;
      f(load_le<std::uint32_t>(p), Bytes(p + 8, length));
      p += 8 + length;
    }
  }
  /// Item 6; nullopt without it.
  [[nodiscard]] std::optional<TiStatistics> statistics() const;
  /// Item 9; nullopt without it.
  [[nodiscard]] std::optional<TiTemperature> temperature() const;

 private:
  friend class TiFraming;

  [[nodiscard]] TiPoint converted_point(std::size_t i) const;

  TiHeader header_;
  std::uint64_t position_ = 0;
  std::size_t points_ = 0;
  Bytes bytes_, items_, coordinates_, side_info_;
  float fixed_point_scale_ = 1.0F;  ///< metres of one unit, before SDK 3
  TiPoints encoding_ = TiPoints::cartesian;
};

inline TiPoint TiFrame::operator[](std::size_t i) const {
  if (encoding_ > TiPoints::cartesian) return converted_point(i);
  TiPoint point;
  if (encoding_ == TiPoints::cartesian) {
    const std::uint8_t* p = &coordinates_[16 * i];
    point.x_m = load_le<float>(p);
    point.y_m = load_le<float>(p + 4);
    point.z_m = load_le<float>(p + 8);
    point.doppler_mps = load_le<float>(p + 12);
  } else {
    const std::uint8_t* p = &coordinates_[12 * i];
    const auto metres = [&](std::size_t at) {
      return static_cast<float>(load_le<std::int16_t>(p + at)) * fixed_point_scale_;
    };
    point.range_bin = load_le<std::uint16_t>(p);
    point.doppler_bin = load_le<std::int16_t>(p + 2);
    point.peak = load_le<std::uint16_t>(p + 4);
    point.x_m = metres(6);
    point.y_m = metres(8);
    point.z_m = metres(10);
  }
  if (!side_info_.empty()) {
    point.snr_ddb = load_le<std::int16_t>(&side_info_[4 * i]);
    point.noise_ddb = load_le<std::int16_t>(&side_info_[4 * i + 2]);
  }
  return point;
}

namespace detail {

/// A ratio as tenths of dB, limited to their range; 0 for none.
[[nodiscard]] inline std::int16_t decibels(double ratio) {
  if (!(ratio > 0.0)) return 0;
  return static_cast<std::int16_t>(std::lround(std::clamp(100.0 * std::log10(ratio), -3e4, 3e4)));
}

/// Tenths of dB, limited to their range.
[[nodiscard]] inline std::int16_t tenths(double decibels) {
  return static_cast<std::int16_t>(
      std::isnan(decibels) ? 0L : std::lround(std::clamp(10.0 * decibels, -3e4, 3e4)));
}

/// x right, y forward, z up.
inline void set_spherical(TiPoint& point, float range, float azimuth, float elevation) {
  const float level = range * std::cos(elevation);
  point.x_m = level * std::sin(azimuth);
  point.y_m = level * std::cos(azimuth);
  point.z_m = range * std::sin(elevation);
}

}  // namespace detail

inline TiPoint TiFrame::converted_point(std::size_t i) const {
  TiPoint point;
  const auto real = [&](std::size_t at) { return load_le<float>(&coordinates_[at]); };
  const auto whole = [&](std::size_t at) {
    return static_cast<float>(load_le<std::int16_t>(&coordinates_[at]));
  };
  if (encoding_ == TiPoints::spherical || encoding_ == TiPoints::polar) {
    const std::size_t at = 16 * i;
    const bool flat = encoding_ == TiPoints::polar;
    detail::set_spherical(point, real(at), real(at + 4), flat ? 0.0F : real(at + 8));
    point.doppler_mps = real(at + (flat ? 8 : 12));
    if (flat) point.snr_ddb = detail::decibels(static_cast<double>(real(at + 12)));
  } else if (encoding_ == TiPoints::compressed) {
    const std::size_t at = 20 + 8 * i;
    const auto angle = [&](std::size_t k) {
      return real(4 * k) * static_cast<float>(static_cast<std::int8_t>(coordinates_[at + k]));
    };
    const float range =
        real(12) * static_cast<float>(load_le<std::uint16_t>(&coordinates_[at + 4]));
    detail::set_spherical(point, range, angle(1), angle(0));
    point.doppler_mps = real(8) * whole(at + 2);
    point.peak = load_le<std::uint16_t>(&coordinates_[at + 6]);
    point.snr_ddb = detail::decibels(static_cast<double>(real(16)) * point.peak);
  } else {
    const std::size_t at = 20 + 10 * i;
    point.x_m = real(0) * whole(at);
    point.y_m = real(0) * whole(at + 2);
    point.z_m = real(0) * whole(at + 4);
    point.doppler_mps = real(4) * whole(at + 6);
    point.snr_ddb = detail::tenths(static_cast<double>(real(8)) * coordinates_[at + 8]);
    point.noise_ddb = detail::tenths(static_cast<double>(real(12)) * coordinates_[at + 9]);
  }
  if (!side_info_.empty()) {
    point.snr_ddb = load_le<std::int16_t>(&side_info_[4 * i]);
    point.noise_ddb = load_le<std::int16_t>(&side_info_[4 * i + 2]);
  }
  return point;
}

inline Bytes TiFrame::find(TiTlv type) const {
  Bytes found;
  bool done = false;
  for_each([&](std::uint32_t t, Bytes payload) {
    if (done || t != static_cast<std::uint32_t>(type)) return;
    found = payload;
    done = true;
  });
  return found;
}

inline std::optional<TiStatistics> TiFrame::statistics() const {
  const Bytes b = find(TiTlv::statistics);
  if (b.size() != 24) return std::nullopt;
  const auto word = [&](std::size_t i) { return load_le<std::uint32_t>(&b[4 * i]); };
  return TiStatistics{word(0), word(1), word(2), word(3), word(4), word(5)};
}

inline std::optional<TiTemperature> TiFrame::temperature() const {
  const Bytes b = find(TiTlv::temperature);
  if (b.size() != 28) return std::nullopt;
  TiTemperature t{load_le<std::int32_t>(b.data()) == 0, load_le<std::uint32_t>(&b[4]), {}};
  for (std::size_t i = 0; i < 10; ++i) t.celsius[i] = load_le<std::int16_t>(&b[8 + 2 * i]);
  return t;
}

/// The frame's points in the radar's frame (x forward, y left). `speed_step_mps` is the width of a
/// Doppler bin (`TiLimits::speed_step_mps`), used before SDK 3 only, whose frames have bins.
/// Without a strength it is 10 log10(peak + 1) before SDK 3, else 0. Points that
/// are not finite are left out. `noise_db`, if given, becomes the noise of each point; empty where
/// the frame has none.
[[nodiscard]] inline RadarScan to_radar_scan(const TiFrame& frame, LogTime time,
                                             double speed_step_mps = 0.0,
                                             std::vector<float>* noise_db = nullptr) {
  if (noise_db != nullptr) noise_db->clear();
  RadarScan scan{time, {}};
  scan.points.reserve(frame.size());
  const bool floats = frame.encoding() != TiPoints::fixed;
  for (std::size_t i = 0; i < frame.size(); ++i) {
    const TiPoint p = frame[i];
    RadarPoint point{p.y_m, -p.x_m, p.z_m, p.doppler_mps, 0.0F};
    if (!floats) {
      point.doppler_m_s = static_cast<float>(speed_step_mps * p.doppler_bin);
      point.snr_db = 10.0F * std::log10(static_cast<float>(p.peak) + 1.0F);
    }
    if (frame.has_strength()) point.snr_db = 0.1F * static_cast<float>(p.snr_ddb);
    if (!std::isfinite(p.x_m + p.y_m + p.z_m) || !std::isfinite(point.doppler_m_s)) continue;
    scan.points.push_back(point);
    if (noise_db != nullptr && frame.has_noise())
      noise_db->push_back(0.1F * static_cast<float>(p.noise_ddb));
  }
  return scan;
}

/// Unwraps `TiHeader::cycles`, which wrap around after 21 s (7 s before SDK 3). Between frames
/// further apart, whole periods of the counter are lost.
class TiClock {
 public:
  /// The sensor's time when the frame was built; the first frame's is its cycles.
  [[nodiscard]] Time<DeviceClock> at(const TiHeader& header) {
    cycles_ += static_cast<std::uint32_t>(header.cycles - static_cast<std::uint32_t>(cycles_));
    const auto ns_per_cycle = 1e9 / ti_clock_hz(header);
    return Time<DeviceClock>::from_nanoseconds(
        std::llround(static_cast<double>(cycles_) * ns_per_cycle));
  }

 private:
  std::uint64_t cycles_ = 0;
};

}  // namespace wayfare::decode
