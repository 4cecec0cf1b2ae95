#pragma once

#include <string>
#include <string_view>

#include "io/columns/column_rows.hpp"

namespace wayfare::io {

struct Unit {
  std::string_view name;
  Dimension dimension = Dimension::none;
  double factor = 1.0;  ///< to SI units; for times the number of decimals to shift
};

/// Null where the unit is unknown.
[[nodiscard]] const Unit* find_unit(std::string_view name, Dimension dimension);
/// The names of a dimension's units, for messages.
[[nodiscard]] std::string units_of(Dimension dimension);

struct ColumnName {
  std::string_view stem;
  std::string_view unit;
};

/// "ax_g" or "ax [m/s^2]" or "ax(m/s^2)" as stem and unit.
[[nodiscard]] ColumnName split_name(std::string_view name);

}  // namespace wayfare::io
