#pragma once

// Positions on the WGS-84 ellipsoid: geodetic, Earth-centred Earth-fixed (ECEF), local level (NED).
//
// Positions near an anchor as north, east and down offsets in metres, so that single precision is
// enough for the offset while the anchor stays double:
//   latitude = latitude₀ + n/(M₀ + h₀), longitude = longitude₀ + e/((N₀ + h₀) cos latitude₀),
//   height = h₀ − d.
// Curvilinear coordinates, a chart of the ellipsoid. For offsets below about 20 km.

#include <algorithm>
#include <cmath>

#include <Eigen/Core>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/pack.hpp>

namespace wayfare {

/// WGS-84 (NIMA TR8350.2, third edition, tables 3.1, 3.3 and 3.4).
namespace wgs84 {
inline constexpr double kSemiMajorAxis_m = 6378137.0;       ///< of the ellipsoid, a
inline constexpr double kFlattening = 1.0 / 298.257223563;  ///< f
inline constexpr double kSemiMinorAxis_m = kSemiMajorAxis_m * (1.0 - kFlattening);  ///< b
inline constexpr double kEccentricitySquared = kFlattening * (2.0 - kFlattening);   ///< e²
inline constexpr double kEarthRate_radps = 7.2921151467e-5;                         ///< ω
inline constexpr double kGravitationalConstant_m3ps2 = 3.986004418e14;  ///< with the atmosphere, GM
inline constexpr double kEquatorGravity_mps2 = 9.7803253359;            ///< γₑ
inline constexpr double kSomigliana = 0.00193185265241;  ///< k of Somigliana's formula
}  // namespace wgs84

/// Latitude and longitude on WGS-84, height above the ellipsoid.
struct Geodetic {
  Angle latitude;         ///< geodetic, north positive
  Angle longitude;        ///< east positive
  double height_m = 0.0;  ///< above the ellipsoid
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

/// Earth-centred, Earth-fixed coordinates, m (Groves 2013, 2.112).
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
    // Within 43 km of the centre x would change its sign, and the latitude pass the pole.
    const double y = ecef_m.z() + ep2 * b * sb * sb * sb;
    const double x = std::max(p - e2 * a * cb * cb * cb, 0.0);
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

/// The inverse of ned_from_geodetic.
[[nodiscard]] inline Geodetic geodetic_from_ned(const Eigen::Vector3d& ned_m,
                                                const Geodetic& origin) {
  return geodetic_from_ecef(ecef_from_geodetic(origin) + rotation_ecef_ned(origin) * ned_m);
}

/// Geometry and gravity of the Earth at a point of the chart.
template <class T>
struct EarthAt {
  T sin_latitude,    ///< geodetic
      cos_latitude;  ///< geodetic
  T meridian_m,      ///< radius of curvature along the meridian, with height
      transverse_m;  ///< the same across it
  T north_scale,     ///< metres on the chart per metre on the ground, along the north
      east_scale;    ///< the same along the east
  T gravity_mps2;    ///< at that height
};

/// The chart about an anchor. Not at the poles, where east has no direction: north and east of a
/// point then are meaningless.
class LocalTangentPlane {
 public:
  LocalTangentPlane() : LocalTangentPlane(Geodetic{}) {}
  /// `anchor` not at a pole.
  explicit LocalTangentPlane(const Geodetic& anchor)
      : anchor_(anchor),
        r_ecef_ned_(rotation_ecef_ned(anchor)),
        ecef_m_(ecef_from_geodetic(anchor)),
        sin_(std::sin(anchor.latitude.radians())),
        cos_(std::cos(anchor.latitude.radians())),
        transverse_m_(transverse_radius_m(sin_)),
        north_m_(meridian_radius_m(sin_) + anchor.height_m),
        east_m_(transverse_m_ + anchor.height_m) {}

  /// Where the offsets are zero.
  [[nodiscard]] const Geodetic& anchor() const { return anchor_; }
  /// The anchor's ECEF position and axes; displacement() is given in these axes.
  [[nodiscard]] const Eigen::Vector3d& ecef_m() const { return ecef_m_; }
  /// Rotates north, east and down at the anchor to ECEF.
  [[nodiscard]] const Eigen::Matrix3d& rotation_ecef_ned_at_anchor() const { return r_ecef_ned_; }

  /// The position at `x`: north, east and down, metres.
  [[nodiscard]] Geodetic geodetic(const Eigen::Vector3d& x) const {
    return {anchor_.latitude + Angle::radians(x[0] / north_m_),
            (anchor_.longitude + Angle::radians(x[1] / (east_m_ * cos_))).wrapped(),
            anchor_.height_m - x[2]};
  }
  /// North, east and down of `p`, metres.
  [[nodiscard]] Eigen::Vector3d offset(const Geodetic& p) const {
    return {(p.latitude - anchor_.latitude).radians() * north_m_,
            (p.longitude - anchor_.longitude).wrapped().radians() * east_m_ * cos_,
            anchor_.height_m - p.height_m};
  }

  /// Geometry and gravity at `x`: north, east and down, metres.
  template <class T>
  [[nodiscard]] EarthAt<T> earth(const Eigen::Matrix<T, 3, 1>& x) const {
    const SinVersine<T> lat = latitude_change(x);
    EarthAt<T> e;
    e.sin_latitude = T(sin_) + T(cos_) * lat.sin - T(sin_) * lat.versine;
    e.cos_latitude = T(cos_) - T(sin_) * lat.sin - T(cos_) * lat.versine;
    const T h = T(anchor_.height_m) - x[2];
    // One square root for both radii: M = N (1 − e²) / w², N = a / w.
    using std::sqrt;
    const T w2 = T(1) - T(wgs84::kEccentricitySquared) * e.sin_latitude * e.sin_latitude;
    const T n = T(wgs84::kSemiMajorAxis_m) / sqrt(w2);
    e.transverse_m = n + h;
    e.meridian_m = n * T(1.0 - wgs84::kEccentricitySquared) / w2 + h;
    e.north_scale = T(north_m_) / e.meridian_m;
    e.east_scale = T(east_m_ * cos_) / (e.transverse_m * e.cos_latitude);
    e.gravity_mps2 = normal_gravity_mps2(e.sin_latitude, h);
    return e;
  }

  /// From the anchor to a point of the chart along the anchor's north, east and down, metres;
  /// differences of nearly equal numbers are multiplied out, so single precision keeps millimetres.
  template <class T>
  [[nodiscard]] Eigen::Matrix<T, 3, 1> displacement(const Eigen::Matrix<T, 3, 1>& x) const {
    const SinVersine<T> lat = latitude_change(x), lon = longitude_change(x);
    // Change of sine and cosine of latitude, and of the transverse radius.
    const T ds = T(cos_) * lat.sin - T(sin_) * lat.versine;
    const T dc = -T(sin_) * lat.sin - T(cos_) * lat.versine;
    const T sp = T(sin_) + ds, cp = T(cos_) + dc;
    using std::sqrt;
    constexpr double e2 = wgs84::kEccentricitySquared;
    const T w = sqrt(T(1) - T(e2) * sp * sp), w0 = T(std::sqrt(1.0 - e2 * sin_ * sin_));
    const T dn = T(wgs84::kSemiMajorAxis_m * e2) * ds * (sp + T(sin_)) / (w * w0 * (w + w0));
    const T dh = -x[2], n0h0 = T(east_m_);
    // ECEF rotated about the pole so that the anchor's meridian is x: radial, east, polar.
    const T ring = dn + dh;
    const T radial = n0h0 * dc + ring * cp - (n0h0 + ring) * cp * lon.versine;
    const T east = (n0h0 + ring) * cp * lon.sin;
    const T polar =
        T(transverse_m_ * (1.0 - e2) + anchor_.height_m) * ds + (T(1.0 - e2) * dn + dh) * sp;
    return {-T(sin_) * radial + T(cos_) * polar, east, -T(cos_) * radial - T(sin_) * polar};
  }

  /// Rotation from local level at a point of the chart to the anchor's.
  template <class T>
  [[nodiscard]] Eigen::Matrix<T, 3, 3> rotation_anchor_local(
      const Eigen::Matrix<T, 3, 1>& x) const {
    const SinVersine<T> lat = latitude_change(x), lon = longitude_change(x);
    const T sp = T(sin_) + T(cos_) * lat.sin - T(sin_) * lat.versine;
    const T cp = T(cos_) - T(sin_) * lat.sin - T(cos_) * lat.versine;
    const T sl = lon.sin, cl = T(1) - lon.versine;
    const T s0 = T(sin_), c0 = T(cos_);
    return (Eigen::Matrix<T, 3, 3>() << s0 * sp * cl + c0 * cp, s0 * sl, s0 * cp * cl - c0 * sp,
            -sp * sl, cl, -cp * sl, c0 * sp * cl - s0 * cp, c0 * sl, c0 * cp * cl + s0 * sp)
        .finished();
  }

 private:
  /// sin x and 1 − cos x of a small angle.
  template <class T>
  struct SinVersine {
    T sin, versine;
  };
  template <class T>
  [[nodiscard]] static SinVersine<T> sin_versine(const T& x) {
    const T x2 = x * x;  // up to 0.05 rad: the neglected terms are below 1e-18
    return {
        x * (T(1) - x2 / T(6) * (T(1) - x2 / T(20) * (T(1) - x2 / T(42) * (T(1) - x2 / T(72))))),
        x2 / T(2) * (T(1) - x2 / T(12) * (T(1) - x2 / T(30) * (T(1) - x2 / T(56))))};
  }
  template <class T>
  [[nodiscard]] SinVersine<T> latitude_change(const Eigen::Matrix<T, 3, 1>& x) const {
    return sin_versine(T(x[0] * T(1.0 / north_m_)));
  }
  template <class T>
  [[nodiscard]] SinVersine<T> longitude_change(const Eigen::Matrix<T, 3, 1>& x) const {
    return sin_versine(T(x[1] * T(1.0 / (east_m_ * cos_))));
  }

  Geodetic anchor_;
  Eigen::Matrix3d r_ecef_ned_;
  Eigen::Vector3d ecef_m_;
  double sin_, cos_;
  double transverse_m_;      // N₀, without height
  double north_m_, east_m_;  // M₀ + h₀, N₀ + h₀
};

}  // namespace wayfare
