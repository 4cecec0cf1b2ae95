#pragma once

#include <numbers>

namespace wayfare::examples {

inline constexpr double kDegree = std::numbers::pi / 180.0;  ///< rad

}  // namespace wayfare::examples
