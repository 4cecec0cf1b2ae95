#include "heat_map.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace wayfare::examples {

io::Colour heat_colour(double value) {
  constexpr std::array<std::array<double, 3>, 5> kStops{
      {{68, 1, 84}, {59, 82, 139}, {33, 145, 140}, {94, 201, 98}, {253, 231, 37}}};
  const double at = std::clamp(value, 0.0, 1.0) * 4.0;
  const auto i = std::min<std::size_t>(3, static_cast<std::size_t>(at));
  io::Colour rgb{};
  for (std::size_t c = 0; c < 3; ++c) {
    const double v =
        kStops[i][c] + (at - static_cast<double>(i)) * (kStops[i + 1][c] - kStops[i][c]);
    rgb[c] = static_cast<std::uint8_t>(std::lround(v));
  }
  return rgb;
}

}  // namespace wayfare::examples
