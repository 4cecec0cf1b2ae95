#pragma once

// From a frame of a TI mmWave sensor to the library's radar scan and clock.

#include <cmath>
#include <cstddef>
#include <cstdint>

#include <wayfare/core/time.hpp>
#include <wayfare/decode/ti_frame.hpp>
#include <wayfare/sensors/radar_scan.hpp>

namespace wayfare::decode {

/// The frame's points in the radar's frame (x forward, y left). `speed_step_mps` is what a Doppler
/// bin is worth (`TiLimits::speed_step_mps`): before SDK 3 a frame has bins only, after it is not
/// used. Where the frame has no side information the strength is that of the peak alone, before
/// SDK 3 as 10 log10(peak + 1), else 0. Points that are not finite are left out.
[[nodiscard]] inline RadarScan to_radar_scan(const TiFrame& frame, LogTime time,
                                             double speed_step_mps = 0.0) {
  RadarScan scan{time, {}};
  scan.points.reserve(frame.size());
  const bool floats = frame.header().major() >= 3;
  for (std::size_t i = 0; i < frame.size(); ++i) {
    const TiPoint p = frame[i];
    if (!std::isfinite(p.x_m + p.y_m + p.z_m) || (floats && !std::isfinite(p.doppler_mps)))
      continue;
    RadarPoint point{p.y_m, -p.x_m, p.z_m, p.doppler_mps, 0.0F};
    if (!floats) {
      point.doppler_m_s = static_cast<float>(speed_step_mps * p.doppler_bin);
      point.snr_db = 10.0F * std::log10(static_cast<float>(p.peak) + 1.0F);
    }
    if (frame.has_side_info()) point.snr_db = 0.1F * static_cast<float>(p.snr_ddb);
    scan.points.push_back(point);
  }
  return scan;
}

/// Brings `TiHeader::cycles`, which come round after 21 s (7 s before SDK 3), to a clock that does
/// not. Frames further apart than that are bridged by their numbers only where the caller knows the
/// period; here they lose whole rounds.
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
