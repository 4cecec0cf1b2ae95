#pragma once

// Private: units of columns, and names of columns as quantity and unit.

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <numbers>
#include <string>
#include <string_view>

#include "io/columns/column_rows.hpp"
#include "io/text/text.hpp"

namespace wayfare::io {

inline constexpr double kGravity_mps2 = 9.80665;
inline constexpr double kDegree = std::numbers::pi / 180.0;

struct Unit {
  std::string_view name;
  Dimension dimension = Dimension::none;
  double factor = 1.0;  ///< to SI units; for times the number of decimals to shift
};

/// Magnetic fields are in microtesla, the usual unit of the Earth's.
inline constexpr Unit kUnits[] = {{"m", Dimension::length, 1.0},
                                  {"cm", Dimension::length, 1e-2},
                                  {"mm", Dimension::length, 1e-3},
                                  {"km", Dimension::length, 1e3},
                                  {"mps", Dimension::speed, 1.0},
                                  {"m/s", Dimension::speed, 1.0},
                                  {"kmh", Dimension::speed, 1.0 / 3.6},
                                  {"km/h", Dimension::speed, 1.0 / 3.6},
                                  {"rad", Dimension::angle, 1.0},
                                  {"deg", Dimension::angle, kDegree},
                                  {"radps", Dimension::angular_rate, 1.0},
                                  {"rad/s", Dimension::angular_rate, 1.0},
                                  {"degps", Dimension::angular_rate, kDegree},
                                  {"deg/s", Dimension::angular_rate, kDegree},
                                  {"mps2", Dimension::acceleration, 1.0},
                                  {"m/s2", Dimension::acceleration, 1.0},
                                  {"m/s^2", Dimension::acceleration, 1.0},
                                  {"g", Dimension::acceleration, kGravity_mps2},
                                  {"mg", Dimension::acceleration, 1e-3 * kGravity_mps2},
                                  {"uT", Dimension::magnetic_field, 1.0},
                                  {"nT", Dimension::magnetic_field, 1e-3},
                                  {"mT", Dimension::magnetic_field, 1e3},
                                  {"T", Dimension::magnetic_field, 1e6},
                                  {"G", Dimension::magnetic_field, 1e2},
                                  {"Pa", Dimension::pressure, 1.0},
                                  {"hPa", Dimension::pressure, 1e2},
                                  {"mbar", Dimension::pressure, 1e2},
                                  {"kPa", Dimension::pressure, 1e3},
                                  {"dbhz", Dimension::decibel_hertz, 1.0},
                                  {"s", Dimension::time, 0.0},
                                  {"ms", Dimension::time, 3.0},
                                  {"us", Dimension::time, 6.0},
                                  {"ns", Dimension::time, 9.0}};

struct ColumnName {
  std::string_view stem;
  std::string_view unit;
};

/// "ax_g" or "ax [m/s^2]" or "ax(m/s^2)" as stem and unit.
inline ColumnName split_name(std::string_view name) {
  const std::size_t bracket = name.find_first_of("[(");
  if (bracket != name.npos && (name.back() == ']' || name.back() == ')'))
    return {text::trimmed(name.substr(0, bracket)),
            text::trimmed(name.substr(bracket + 1, name.size() - bracket - 2))};
  const std::size_t underscore = name.rfind('_');
  if (underscore == name.npos) return {name, {}};
  return {name.substr(0, underscore), name.substr(underscore + 1)};
}

/// Null where the unit is unknown.
inline const Unit* find_unit(std::string_view name, Dimension dimension) {
  const auto* unit = std::find_if(std::begin(kUnits), std::end(kUnits), [&](const Unit& u) {
    return u.name == name && u.dimension == dimension;
  });
  return unit == std::end(kUnits) ? nullptr : unit;
}

/// The names of a dimension's units, for messages.
inline std::string units_of(Dimension dimension) {
  std::string list;
  for (const Unit& u : kUnits) {
    if (u.dimension != dimension) continue;
    list += list.empty() ? "" : ", ";
    list += u.name;
  }
  return list;
}

}  // namespace wayfare::io
