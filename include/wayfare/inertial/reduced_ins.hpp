#pragma once

// Navigation with one vertical gyro and the wheels (Liu, Atia, Karamat and Noureldin 2015, section
// 3.1): in latitude and longitude, and in a local plane. The gyro's axis points up, so that it
// counts counter-clockwise as positive; azimuth counts clockwise from north.

#include <cmath>

#include <wayfare/core/geodesy.hpp>
#include <wayfare/core/se2.hpp>

namespace wayfare {

/// Where a vehicle is on the Earth and where it faces.
struct GeodeticHeading {
  Geodetic position;
  Angle azimuth;  ///< clockwise from north
};

/// What a gyro that points up feels of the Earth's turn and of the level's own (1), rad/s.
[[nodiscard]] inline double level_rate_rad_s(const Geodetic& at, double east_speed_m_s) {
  const double s = std::sin(at.latitude.radians());
  return wgs84::kEarthRate_radps * s +
         east_speed_m_s * std::tan(at.latitude.radians()) / (transverse_radius_m(s) + at.height_m);
}

/// (1) to (5) over `dt_s` with the turn rate and the forward speed held; `turn_rate_rad_s` is the
/// gyro's reading less its bias. The heading of the middle of the step is used: second order.
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

/// The same in a plane: along the arc. `turn_rate_rad_s` is also less the level's own rate.
[[nodiscard]] inline SE2d advance(const SE2d& from, double turn_rate_rad_s, double speed_m_s,
                                  double dt_s) {
  return from.plus({speed_m_s * dt_s, 0.0, turn_rate_rad_s * dt_s});
}

/// A plane laid on the Earth: its origin, and where its x axis points.
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
