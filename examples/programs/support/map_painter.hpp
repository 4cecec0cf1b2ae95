#pragma once

#include <array>
#include <cstdint>
#include <span>

#include <Eigen/Core>

#include <wayfare/io/map_image.hpp>

namespace wayfare::examples {

using Colour = std::array<std::uint8_t, 3>;
inline constexpr Colour kBlue = {21, 101, 192};
inline constexpr Colour kRed = {211, 47, 47};
inline constexpr Colour kGreen = {46, 125, 50};

/// Draws on the image of a map; positions in metres, in the map's frame.
class MapPainter {
 public:
  explicit MapPainter(const io::GridImage& grid);

  /// A square with a side of `side` pixels.
  MapPainter& dot(const Eigen::Vector2d& position_m, const Colour& colour, int side = 2);
  /// Two pixels wide.
  MapPainter& path(std::span<const Eigen::Vector2d> positions_m, const Colour& colour);

  [[nodiscard]] const io::Image& picture() const { return picture_; }

 private:
  SE2d T_grid_map_;
  double resolution_m_;
  io::Image picture_;
};

}  // namespace wayfare::examples
