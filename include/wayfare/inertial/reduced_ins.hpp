#pragma once

// Navigation with one vertical gyro and wheel odometry (Liu, Atia, Karamat and Noureldin 2015,
// section 3.1): in latitude and longitude, and in a local plane. The gyro's axis points up
// (counter-clockwise positive); azimuth is clockwise from north.

#include <cmath>

#include <wayfare/core/geodesy.hpp>
#include <wayfare/core/se2.hpp>

namespace wayfare {

/// Geodetic position and azimuth of a vehicle.
struct GeodeticHeading {
  Geodetic position;
  Angle azimuth;  ///< clockwise from north
};

/// Earth rate and transport rate measured by an upward gyro (1), rad/s.
[[nodiscard]] inline double level_rate_rad_s(const Geodetic& at, double east_speed_m_s) {
  const double s = std::sin(at.latitude.radians());
  return wgs84::kEarthRate_radps * s +
         east_speed_m_s * std::tan(at.latitude.radians()) / (transverse_radius_m(s) + at.height_m);
}

/// (1) to (5) over `dt_s` at constant turn rate and forward speed; `turn_rate_rad_s` is the gyro
/// reading less its bias. Midpoint heading: second order.
[[nodiscard]] inline GeodeticHeading advance(const GeodeticHeading& from, double turn_rate_rad_s,
                                             double speed_m_s, double dt_s) {
  const double a0 = from.azimuth.radians();
  const double level = level_rate_rad_s(from.position, speed_m_s * std::sin(a0));
  const double a1 = a0 - (turn_rate_rad_s - level) * dt_s, middle = 0.5 * (a0 + a1);
  const double s = std::sin(from.position.latitude.radians()), h = from.position.height_m;
  const double north = speed_m_s * std::cos(middle) * dt_s / (meridian_radius_m(s) + h);
  const double east = speed_m_s * std::sin(middle) * dt_s /
                      ((transverse_radius_m(s) + h) * std::cos(from.position.latitude.radians()));
  return {{from.position.latitude + Angle::radians(north),
           from.position.longitude + Angle::radians(east), h},
          Angle::radians(a1).wrapped()};
}

/// The same in a plane, along the arc. `turn_rate_rad_s` is also less the Earth and transport rate.
[[nodiscard]] inline SE2d advance(const SE2d& from, double turn_rate_rad_s, double speed_m_s,
                                  double dt_s) {
  return from.plus({speed_m_s * dt_s, 0.0, turn_rate_rad_s * dt_s});
}

/// A local plane on the Earth: its origin and the azimuth of its x axis.
struct LocalPlane {
  Geodetic origin;
  Angle azimuth_of_x;

  [[nodiscard]] GeodeticHeading geodetic(const SE2d& pose) const {
    const double a = azimuth_of_x.radians(), c = std::cos(a), s = std::sin(a);
    // x points along the azimuth, y to its left.
    const Eigen::Vector3d ned(c * pose.x() + s * pose.y(), s * pose.x() - c * pose.y(), 0.0);
    return {geodetic_from_ned(ned, origin), (azimuth_of_x - pose.heading()).wrapped()};
  }
};

}  // namespace wayfare
