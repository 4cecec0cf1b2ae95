#pragma once

// Atmospheric range delays: Klobuchar's ionosphere model, Saastamoinen's troposphere model.
//
// Pseudoranges and their rates as measurements of InsState: geometry, lever arm, receiver clock.
// Zhang 2020, (3.7)-(3.8), with the lever arm's terms (Groves 2013, section 14.3.2).

#include <array>

#include <Eigen/Core>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/geodesy.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/filter/sequential_update.hpp>
#include <wayfare/inertial/ins_state.hpp>
#include <wayfare/sensors/measurements.hpp>

namespace wayfare {

/// The direction to a satellite in the local level: azimuth clockwise from north, [0, 2π).
struct LineOfSight {
  double azimuth_rad = 0.0;    ///< clockwise from north
  double elevation_rad = 0.0;  ///< above the horizon
};

/// Azimuth and elevation of a satellite, about the ellipsoid's vertical at the receiver.
[[nodiscard]] LineOfSight line_of_sight(const Geodetic& receiver,
                                        const Eigen::Vector3d& satellite_ecef_m);

/// Broadcast coefficients of the single-layer model of the ionosphere (Klobuchar 1987).
struct KlobucharModel {
  std::array<double, 4> alpha{};  ///< amplitude: s, s/semicircle, …
  std::array<double, 4> beta{};   ///< period: s, s/semicircle, …
  double carrier_hz = 1575.42e6;  ///< carrier of the coefficients
};

/// Delay in metres on `carrier_hz` (IS-GPS-200 20.3.3.5.2.5; scaled by the square of the
/// frequencies' ratio). Zero below the horizon and for a receiver above 400 km.
[[nodiscard]] double ionosphere_delay_m(const KlobucharModel& model, Time<GpsClock> time,
                                        const Geodetic& receiver, const LineOfSight& sight,
                                        double carrier_hz);

/// Delay in metres at the zenith of a standard atmosphere (15 °C and 1013.25 hPa at sea level) with
/// the given relative humidity (Saastamoinen 1972). Zero above 10 km and below −100 m of height.
[[nodiscard]] double zenith_troposphere_delay_m(const Geodetic& receiver,
                                                double relative_humidity = 0.7);

/// Mapping function of the troposphere (Black and Eisner 1984): close to 1 / sin of the elevation
/// above 20°, 3 % less at 10° and 10 % less at 5° because of the Earth's curvature.
[[nodiscard]] double troposphere_mapping(double elevation_rad);

/// The product of the two; zero below the horizon.
[[nodiscard]] double troposphere_delay_m(const Geodetic& receiver, const LineOfSight& sight,
                                         double relative_humidity = 0.7);

/// A satellite relative to the tangent plane's anchor, in the anchor's north, east and down; the
/// anchor's range is subtracted in double precision.
struct SatelliteView {
  Eigen::Vector3d position_m,   ///< of the satellite
      velocity_mps;             ///< over the Earth
  double anchor_range_m = 0.0;  ///< distance of satellite and anchor

  /// Of a satellite of a corrected range.
  SatelliteView(const CorrectedRange& satellite, const LocalTangentPlane& plane)
      : position_m(plane.rotation_ecef_ned_at_anchor().transpose() *
                   (satellite.position_ecef_m - plane.ecef_m())),
        velocity_mps(plane.rotation_ecef_ned_at_anchor().transpose() * satellite.velocity_ecef_mps),
        anchor_range_m(position_m.norm()) {}
};

/// Position and velocity of the antenna in the anchor's axes, and their derivatives.
template <class T>
struct AntennaView {
  using Vector3 = Eigen::Matrix<T, 3, 1>;  ///< of three components
  using Matrix3 = Eigen::Matrix<T, 3, 3>;  ///< rotations
  Matrix3 anchor_local;                    ///< local level to the anchor's axes
  Matrix3 anchor_unit;                     ///< the unit's axes to the anchor's
  Vector3 position_m;                      ///< from the anchor
  Vector3 velocity_mps;                    ///< over the Earth
  Vector3 plane_scale;                     ///< metres on the ground per metre on the plane
  Vector3 lever_m,                         ///< lever arm
      swing_mps;                           ///< ω × lever arm

  /// `lever_m` from the unit to the antenna and `rate_radps` the turn rate, both in its axes.
  template <int Offsets, class... Further>
  AntennaView(const InsState<T, Offsets, Further...>& x, const LocalTangentPlane& plane,
              const Vector3& lever, const Vector3& rate_radps)
      : anchor_local(plane.rotation_anchor_local(x.position_m)),
        anchor_unit(anchor_local * x.q_nu.matrix()),
        lever_m(lever),
        swing_mps(rate_radps.cross(lever)) {
    position_m = plane.displacement(x.position_m) + anchor_unit * lever_m;
    velocity_mps = anchor_local * x.velocity_mps + anchor_unit * swing_mps;
    const EarthAt<T> at = plane.earth(x.position_m);
    plane_scale = Vector3(T(1) / at.north_scale, T(1) / at.east_scale, T(1));
  }
};

/// Line of sight and range difference to the anchor, in a form accurate in single precision: |s −
/// x| − |s| = (|x|² − 2 s·x)/(|s − x| + |s|).
template <class T>
struct RangeGeometry {
  using Vector3 = Eigen::Matrix<T, 3, 1>;  ///< of three components
  Vector3 direction;                       ///< from antenna to satellite, in the anchor's axes
  T range_m;                               ///< from antenna to satellite
  T range_difference_m;                    ///< range_m less the anchor's range

  /// Of one satellite and antenna.
  RangeGeometry(const SatelliteView& satellite, const AntennaView<T>& antenna) {
    using std::sqrt;
    const Vector3 s = satellite.position_m.cast<T>();
    const Vector3 d = s - antenna.position_m;
    range_m = sqrt(d.squaredNorm());
    direction = d / range_m;
    range_difference_m = antenna.position_m.dot(antenna.position_m - T(2) * s) /
                         (range_m + T(satellite.anchor_range_m));
  }
};

/// range − |s − p| − clock. `excess_m` is the measured range less the anchor's range and the
/// clock's anchor; `clock_offset` is the index of an inter-system offset to add (−1: none).
template <class T, int Offsets = 0>
struct RangeModel {
  const LocalTangentPlane& plane;  ///< of the state's positions; must outlive this
  SatelliteView satellite;         ///< of the satellite measured
  double excess_m;                 ///< see above
  T variance;                      ///< of the range, m²
  Eigen::Matrix<T, 3, 1> lever_m;  ///< the unit's axes
  int clock_offset = -1;           ///< index, or −1

  static constexpr int kEntries = 6 + 2;  ///< numbers of a row that are not zero: three, three, two
  using Row = SparseRow<T, kEntries>;     ///< the nonzero numbers of H

  /// Innovation, row and variance at a state, an InsState.
  [[nodiscard]] ScalarMeasurement<T, Row> operator()(const auto& x) const {
    using namespace ins_state;
    using Vector3 = Eigen::Matrix<T, 3, 1>;
    const AntennaView<T> antenna(x, plane, lever_m, Vector3::Zero());
    const RangeGeometry<T> sight(satellite, antenna);
    // The position error moves p along the local level axes; δθ rotates the lever arm.
    const Vector3 by_position =
        -(antenna.anchor_local.transpose() * sight.direction).cwiseProduct(antenna.plane_scale);
    const Vector3 u_unit = antenna.anchor_unit.transpose() * sight.direction;
    const Vector3 by_attitude = u_unit.cross(lever_m);
    const bool offset = clock_offset >= 0;
    const int further = offset ? kClock + 2 + clock_offset : kClock;
    const T bias = x.clock[0] + (offset ? x.clock[2 + clock_offset] : T(0));
    return {T(excess_m) - sight.range_difference_m - bias,
            {{0, 1, 2, 6, 7, 8, kClock, further},
             {by_position[0], by_position[1], by_position[2], by_attitude[0], by_attitude[1],
              by_attitude[2], T(1), offset ? T(1) : T(0)}},
            variance};
  }
};

/// rate − uᵀ(satellite velocity − antenna velocity) − clock drift.
template <class T, int Offsets = 0>
struct RangeRateModel {
  const LocalTangentPlane& plane;  ///< of the state's positions; must outlive this
  SatelliteView satellite;         ///< of the satellite measured
  double range_rate_mps;           ///< measured, positive when receding
  T variance;                      ///< of the range rate, (m/s)²
  Eigen::Matrix<T, 3, 1> lever_m;  ///< the unit's axes
  /// As measured, in the unit's axes.
  Eigen::Matrix<T, 3, 1> gyro_radps;

  static constexpr int kEntries = 13;  ///< numbers of a row that are not zero
  using Row = SparseRow<T, kEntries>;  ///< the nonzero numbers of H

  /// Innovation, row and variance at a state, an InsState.
  [[nodiscard]] ScalarMeasurement<T, Row> operator()(const auto& x) const {
    using namespace ins_state;
    using Vector3 = Eigen::Matrix<T, 3, 1>;
    const Vector3 inverse_scale = (x.gyro_scale.array() + T(1)).inverse();
    const Vector3 rate = (gyro_radps - x.gyro_bias_radps).cwiseProduct(inverse_scale);
    const AntennaView<T> antenna(x, plane, lever_m, rate);
    const RangeGeometry<T> sight(satellite, antenna);
    const Vector3 relative = satellite.velocity_mps.cast<T>() - antenna.velocity_mps;
    const T along = sight.direction.dot(relative);
    // A position error rotates the line of sight (small).
    const Vector3 turn = (sight.direction * along - relative) / sight.range_m;
    const Vector3 by_position =
        (antenna.anchor_local.transpose() * turn).cwiseProduct(antenna.plane_scale);
    const Vector3 by_velocity = -(antenna.anchor_local.transpose() * sight.direction);
    const Vector3 u_unit = antenna.anchor_unit.transpose() * sight.direction;
    const Vector3 turn_unit = antenna.anchor_unit.transpose() * turn;
    const Vector3 by_attitude = u_unit.cross(antenna.swing_mps) - turn_unit.cross(lever_m);
    // swing = ω × l, ∂ω/∂b = −1/(1 + s): −uᵀ(−(δb/(1+s)) × l) = (l × u)ᵀ δb/(1+s).
    const Vector3 by_bias = lever_m.cross(u_unit).cwiseProduct(inverse_scale);
    return {T(range_rate_mps) - along - x.clock[1],
            {{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, kClock + 1},
             {by_position[0], by_position[1], by_position[2], by_velocity[0], by_velocity[1],
              by_velocity[2], by_attitude[0], by_attitude[1], by_attitude[2], by_bias[0],
              by_bias[1], by_bias[2], T(1)}},
            variance};
  }
};

}  // namespace wayfare
