#include "io/columns/column_units.hpp"

#include <algorithm>
#include <array>
#include <numbers>

#include "io/text/text.hpp"

namespace wayfare::io {
namespace {

constexpr double kGravity_mps2 = 9.80665;
constexpr double kDegree = std::numbers::pi / 180.0;

constexpr std::array kUnits = {
    Unit{"m", Dimension::length, 1.0},
    Unit{"cm", Dimension::length, 1e-2},
    Unit{"mm", Dimension::length, 1e-3},
    Unit{"km", Dimension::length, 1e3},
    Unit{"mps", Dimension::speed, 1.0},
    Unit{"m/s", Dimension::speed, 1.0},
    Unit{"kmh", Dimension::speed, 1.0 / 3.6},
    Unit{"km/h", Dimension::speed, 1.0 / 3.6},
    Unit{"rad", Dimension::angle, 1.0},
    Unit{"deg", Dimension::angle, kDegree},
    Unit{"radps", Dimension::angular_rate, 1.0},
    Unit{"rad/s", Dimension::angular_rate, 1.0},
    Unit{"degps", Dimension::angular_rate, kDegree},
    Unit{"deg/s", Dimension::angular_rate, kDegree},
    Unit{"mps2", Dimension::acceleration, 1.0},
    Unit{"m/s2", Dimension::acceleration, 1.0},
    Unit{"m/s^2", Dimension::acceleration, 1.0},
    Unit{"g", Dimension::acceleration, kGravity_mps2},
    Unit{"mg", Dimension::acceleration, 1e-3 * kGravity_mps2},
    // In microtesla, the usual unit of the Earth's field.
    Unit{"uT", Dimension::magnetic_field, 1.0},
    Unit{"nT", Dimension::magnetic_field, 1e-3},
    Unit{"mT", Dimension::magnetic_field, 1e3},
    Unit{"T", Dimension::magnetic_field, 1e6},
    Unit{"G", Dimension::magnetic_field, 1e2},
    Unit{"dbhz", Dimension::decibel_hertz, 1.0},
    // For times the factor is the number of decimals to shift.
    Unit{"s", Dimension::time, 0.0},
    Unit{"ms", Dimension::time, 3.0},
    Unit{"us", Dimension::time, 6.0},
    Unit{"ns", Dimension::time, 9.0},
};

}  // namespace

ColumnName split_name(std::string_view name) {
  const std::size_t bracket = name.find_first_of("[(");
  if (bracket != name.npos && (name.back() == ']' || name.back() == ')'))
    return {text::trimmed(name.substr(0, bracket)),
            text::trimmed(name.substr(bracket + 1, name.size() - bracket - 2))};
  const std::size_t underscore = name.rfind('_');
  if (underscore == name.npos) return {name, {}};
  return {name.substr(0, underscore), name.substr(underscore + 1)};
}

const Unit* find_unit(std::string_view name, Dimension dimension) {
  const auto unit = std::find_if(kUnits.begin(), kUnits.end(), [&](const Unit& u) {
    return u.name == name && u.dimension == dimension;
  });
  return unit == kUnits.end() ? nullptr : &*unit;
}

std::string units_of(Dimension dimension) {
  std::string list;
  for (const Unit& u : kUnits) {
    if (u.dimension != dimension) continue;
    list += list.empty() ? "" : ", ";
    list += u.name;
  }
  return list;
}

}  // namespace wayfare::io
