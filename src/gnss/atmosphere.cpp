#include <wayfare/gnss/range_model.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

#include <wayfare/gnss/ephemerides.hpp>
#include <wayfare/gnss/gps_time.hpp>

namespace wayfare {
namespace {
constexpr double kPi = std::numbers::pi;
}

LineOfSight line_of_sight(const Geodetic& receiver, const Eigen::Vector3d& satellite_ecef_m) {
  const Eigen::Vector3d ned =
      rotation_ecef_ned(receiver).transpose() * (satellite_ecef_m - ecef_from_geodetic(receiver));
  const double azimuth = std::atan2(ned.y(), ned.x());
  return {azimuth < 0.0 ? azimuth + 2.0 * kPi : azimuth,
          std::atan2(-ned.z(), std::hypot(ned.x(), ned.y()))};
}

double ionosphere_delay_m(const KlobucharModel& model, Time<GpsClock> time,
                          const Geodetic& receiver, const LineOfSight& sight, double carrier_hz) {
  constexpr double kLayerHeight = 400e3;
  if (!(sight.elevation_rad > 0.0) || receiver.height_m > kLayerHeight) return 0.0;
  // The model is in semicircles.
  const double elevation = sight.elevation_rad / kPi;
  const double earth_angle = 0.0137 / (elevation + 0.11) - 0.022;
  const double latitude = std::clamp(
      receiver.latitude.radians() / kPi + earth_angle * std::cos(sight.azimuth_rad), -0.416, 0.416);
  const double longitude = receiver.longitude.radians() / kPi +
                           earth_angle * std::sin(sight.azimuth_rad) / std::cos(latitude * kPi);
  const double magnetic = latitude + 0.064 * std::cos((longitude - 1.617) * kPi);
  double local = std::fmod(43200.0 * longitude + to_seconds(week_time(time).of_week), 86400.0);
  if (local < 0.0) local += 86400.0;
  const auto cubic = [&](const std::array<double, 4>& c) {
    return c[0] + magnetic * (c[1] + magnetic * (c[2] + magnetic * c[3]));
  };
  const double amplitude = std::max(cubic(model.alpha), 0.0);
  const double period = std::max(cubic(model.beta), 72000.0);
  const double slant = 1.0 + 16.0 * std::pow(0.53 - elevation, 3);
  const double x = 2.0 * kPi * (local - 50400.0) / period;
  // The model prescribes this expansion of the cosine.
  const double day = std::abs(x) < 1.57 ? amplitude * (1.0 + x * x * (-0.5 + x * x / 24.0)) : 0.0;
  const double ratio = model.carrier_hz / carrier_hz;
  return kSpeedOfLight_mps * slant * (5e-9 + day) * ratio * ratio;
}

double zenith_troposphere_delay_m(const Geodetic& receiver, double relative_humidity) {
  const double height = receiver.height_m;
  if (height < -100.0 || height > 1e4) return 0.0;
  const double h = std::max(height, 0.0);
  const double pressure_hpa = 1013.25 * std::pow(1.0 - 2.2557e-5 * h, 5.2568);
  const double temperature_k = 15.0 - 6.5e-3 * h + 273.16;
  const double vapour_hpa = 6.108 * relative_humidity *
                            std::exp((17.15 * temperature_k - 4684.0) / (temperature_k - 38.45));
  const double hydrostatic =
      0.0022768 * pressure_hpa /
      (1.0 - 0.00266 * std::cos(2.0 * receiver.latitude.radians()) - 0.00028 * h / 1e3);
  const double wet = 0.002277 * (1255.0 / temperature_k + 0.05) * vapour_hpa;
  return hydrostatic + wet;
}

double troposphere_mapping(double elevation_rad) {
  const double s = std::sin(elevation_rad);
  return 1.001 / std::sqrt(0.002001 + s * s);
}

double troposphere_delay_m(const Geodetic& receiver, const LineOfSight& sight,
                           double relative_humidity) {
  if (!(sight.elevation_rad > 0.0)) return 0.0;
  return zenith_troposphere_delay_m(receiver, relative_humidity) *
         troposphere_mapping(sight.elevation_rad);
}

}  // namespace wayfare
