#pragma once

#include <vector>

#include <wayfare/core/time.hpp>

namespace wayfare {

/// A reflection a millimetre-wave radar detected, in the radar's own frame: x forward, y left,
/// z up, metres.
struct RadarPoint {
  float x_m = 0.0F;
  float y_m = 0.0F;
  float z_m = 0.0F;          ///< 0 where the radar does not measure elevation
  float doppler_m_s = 0.0F;  ///< radial speed, positive away from the radar
  float snr_db = 0.0F;       ///< signal over the noise of its range and Doppler cell

  friend bool operator==(const RadarPoint&, const RadarPoint&) = default;
};

/// The detections of one radar frame; often none. Unlike a laser beam without a return, a direction
/// without a point carries no information about free space.
struct RadarScan {
  LogTime time;
  std::vector<RadarPoint> points = {};
};

}  // namespace wayfare
