#pragma once

// Positions on the WGS-84 ellipsoid: geodetic, Earth-centred Earth-fixed (ECEF), local level (NED).

#include <cmath>

#include <Eigen/Core>

#include <wayfare/core/angle.hpp>

namespace wayfare {

/// WGS-84 (NIMA TR8350.2, third edition, tables 3.1, 3.3 and 3.4).
namespace wgs84 {
inline constexpr double kSemiMajorAxis_m = 6378137.0;
inline constexpr double kFlattening = 1.0 / 298.257223563;
inline constexpr double kSemiMinorAxis_m = kSemiMajorAxis_m * (1.0 - kFlattening);
inline constexpr double kEccentricitySquared = kFlattening * (2.0 - kFlattening);
inline constexpr double kEarthRate_radps = 7.2921151467e-5;
inline constexpr double kGravitationalConstant_m3ps2 = 3.986004418e14;
inline constexpr double kEquatorGravity_mps2 = 9.7803253359;
inline constexpr double kSomigliana = 0.00193185265241;
}  // namespace wgs84

/// Latitude and longitude on WGS-84, height above the ellipsoid.
struct Geodetic {
  Angle latitude;
  Angle longitude;
  double height_m = 0.0;
};

/// Radius of curvature along the meridian (north-south), without height, metres.
template <class T>
[[nodiscard]] T meridian_radius_m(const T& sin_latitude) {
  using std::sqrt;
  const T w2 = T(1) - T(wgs84::kEccentricitySquared) * sin_latitude * sin_latitude;
  return T(wgs84::kSemiMajorAxis_m * (1.0 - wgs84::kEccentricitySquared)) / (w2 * sqrt(w2));
}

/// Radius of curvature across the meridian (east-west), without height, metres.
template <class T>
[[nodiscard]] T transverse_radius_m(const T& sin_latitude) {
  using std::sqrt;
  return T(wgs84::kSemiMajorAxis_m) /
         sqrt(T(1) - T(wgs84::kEccentricitySquared) * sin_latitude * sin_latitude);
}

/// Magnitude of gravity (gravitation and centrifugal), m/s²: Somigliana on the ellipsoid
/// (TR8350.2 (4-1)) and its second-order change with height (4-3).
template <class T>
[[nodiscard]] T normal_gravity_mps2(const T& sin_latitude, const T& height_m) {
  using std::sqrt;
  constexpr double a = wgs84::kSemiMajorAxis_m;
  constexpr double f = wgs84::kFlattening;
  constexpr double m = wgs84::kEarthRate_radps * wgs84::kEarthRate_radps * a * a *
                       wgs84::kSemiMinorAxis_m / wgs84::kGravitationalConstant_m3ps2;
  const T s2 = sin_latitude * sin_latitude;
  const T on_ellipsoid = T(wgs84::kEquatorGravity_mps2) * (T(1) + T(wgs84::kSomigliana) * s2) /
                         sqrt(T(1) - T(wgs84::kEccentricitySquared) * s2);
  const T h = height_m / T(a);
  return on_ellipsoid * (T(1) - T(2) * (T(1.0 + f + m) - T(2.0 * f) * s2) * h + T(3) * h * h);
}

/// Rotates local-level coordinates (north, east, down) at `at` to ECEF.
[[nodiscard]] inline Eigen::Matrix3d rotation_ecef_ned(const Geodetic& at) {
  const double sp = std::sin(at.latitude.radians()), cp = std::cos(at.latitude.radians());
  const double sl = std::sin(at.longitude.radians()), cl = std::cos(at.longitude.radians());
  return (Eigen::Matrix3d() << -sp * cl, -sl, -cp * cl,  //
          -sp * sl, cl, -cp * sl,                        //
          cp, 0.0, -sp)
      .finished();
}

[[nodiscard]] inline Eigen::Vector3d ecef_from_geodetic(const Geodetic& p) {
  const double sp = std::sin(p.latitude.radians()), cp = std::cos(p.latitude.radians());
  const double n = transverse_radius_m(sp);
  return {(n + p.height_m) * cp * std::cos(p.longitude.radians()),
          (n + p.height_m) * cp * std::sin(p.longitude.radians()),
          (n * (1.0 - wgs84::kEccentricitySquared) + p.height_m) * sp};
}

/// Accurate to a few units of rounding (1e-8 m near the ground) from 10 km below the ellipsoid to
/// beyond the satellites' orbits: Bowring's parametric latitude, iterated (Bowring 1976). The
/// centre of the Earth is returned as a pole.
[[nodiscard]] inline Geodetic geodetic_from_ecef(const Eigen::Vector3d& ecef_m) {
  constexpr double a = wgs84::kSemiMajorAxis_m, b = wgs84::kSemiMinorAxis_m;
  constexpr double e2 = wgs84::kEccentricitySquared, ep2 = e2 / (1.0 - e2);
  const double p = std::hypot(ecef_m.x(), ecef_m.y());
  double tan_beta_y = ecef_m.z() * a, tan_beta_x = p * b;
  double sin_phi = 0.0, cos_phi = 1.0;
  for (int round = 0; round < 3; ++round) {
    const double length = std::hypot(tan_beta_y, tan_beta_x);
    const double sb = length > 0.0 ? tan_beta_y / length : 1.0;
    const double cb = length > 0.0 ? tan_beta_x / length : 0.0;
    const double y = ecef_m.z() + ep2 * b * sb * sb * sb, x = p - e2 * a * cb * cb * cb;
    const double norm = std::hypot(x, y);
    sin_phi = norm > 0.0 ? y / norm : 1.0;
    cos_phi = norm > 0.0 ? x / norm : 0.0;
    tan_beta_y = (1.0 - wgs84::kFlattening) * sin_phi;
    tan_beta_x = cos_phi;
  }
  const double n = transverse_radius_m(sin_phi);
  const double height = p * cos_phi + ecef_m.z() * sin_phi - a * a / n;
  return {Angle::radians(std::atan2(sin_phi, cos_phi)),
          Angle::radians(std::atan2(ecef_m.y(), ecef_m.x())), height};
}

/// Position of `p` relative to `origin`, in the local level of `origin`, metres.
[[nodiscard]] inline Eigen::Vector3d ned_from_geodetic(const Geodetic& p, const Geodetic& origin) {
  return rotation_ecef_ned(origin).transpose() *
         (ecef_from_geodetic(p) - ecef_from_geodetic(origin));
}

[[nodiscard]] inline Geodetic geodetic_from_ned(const Eigen::Vector3d& ned_m,
                                                const Geodetic& origin) {
  return geodetic_from_ecef(ecef_from_geodetic(origin) + rotation_ecef_ned(origin) * ned_m);
}

}  // namespace wayfare
