#pragma once

// Air pressure and height in the international standard atmosphere (ISO 2533), below 11 km.

#include <cmath>

namespace wayfare {

namespace detail {

inline constexpr double kAtmosphereTemperature_K = 288.15, kAtmosphereLapse_KPerM = 0.0065;
inline constexpr double kAirGasConstant = 287.05287;  // J/(kg K)
inline constexpr double kAtmosphereExponent =
    kAirGasConstant * kAtmosphereLapse_KPerM / 9.80665;  // 0.190263

}  // namespace detail

/// International barometric formula: the height in m above the place with pressure `reference_Pa`,
/// h = (T/L)·(1 − (p/p₀)^(R·L/g)), with T = 288.15 K at that place. A real temperature T′ scales it
/// by T′/T: 1.7 % for 5 K. Both pressures are positive.
[[nodiscard]] inline double barometric_height_m(double pressure_Pa, double reference_Pa) {
  return detail::kAtmosphereTemperature_K / detail::kAtmosphereLapse_KPerM *
         (1.0 - std::pow(pressure_Pa / reference_Pa, detail::kAtmosphereExponent));
}

/// The inverse: the pressure at this height above the place with `reference_Pa`.
[[nodiscard]] inline double barometric_pressure_Pa(double height_m, double reference_Pa) {
  const double part =
      1.0 - height_m * detail::kAtmosphereLapse_KPerM / detail::kAtmosphereTemperature_K;
  return reference_Pa * std::pow(part, 1.0 / detail::kAtmosphereExponent);
}

}  // namespace wayfare
