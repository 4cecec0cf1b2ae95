#pragma once

#include <wayfare/io/map_image.hpp>

namespace wayfare::examples {

/// Of a value in [0, 1]: from dark blue over green to yellow, with increasing lightness. Values
/// outside are clamped.
[[nodiscard]] io::Colour heat_colour(double value);

}  // namespace wayfare::examples
