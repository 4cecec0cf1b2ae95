#pragma once

// Atmospheric range delays: Klobuchar's ionosphere model, Saastamoinen's troposphere model.

#include <array>

#include <Eigen/Core>

#include <wayfare/core/angle.hpp>
#include <wayfare/core/geodesy.hpp>
#include <wayfare/core/time.hpp>

namespace wayfare {

/// The direction to a satellite in the local level: azimuth clockwise from north, [0, 2π).
struct LineOfSight {
  double azimuth_rad = 0.0;
  double elevation_rad = 0.0;
};

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

}  // namespace wayfare
