#pragma once

// Occupancy maps as PGM and YAML in the format of ROS map_server, and as images for viewing.
//
// Occupied voxels or points as text, one per line, in the format of ColoRadar's maps: "(x y z)" or
// "x,y,z", metres. Brackets, commas and blanks separate the numbers.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/result.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/map/occupancy_grid.hpp>

namespace wayfare::io {

/// Eight bits per channel, rows from the top, one (grey) or three (red, green, blue) channels.
struct Image {
  std::size_t width = 0;
  std::size_t height = 0;
  std::size_t channels = 1;
  std::vector<std::uint8_t> pixels;  ///< width · height · channels
};

/// The bytes of a PNG file. Errors: no pixels, or inconsistent sizes.
[[nodiscard]] Result<std::string> encode_png(const Image& image);

[[nodiscard]] Result<void> write_png(const std::string& path, const Image& image,
                                     const WriteOptions& options = {});

/// A rectangle of cells. Cell (column, row) covers from (column, row) · resolution on, in the frame
/// whose pose in the map is `origin`: the lower left corner of the first cell.
struct GridImage {
  std::size_t width = 0;
  std::size_t height = 0;
  double resolution_m = 0.05;
  SE2d origin{};
  /// Probability that the cell is occupied, row by row from the lowest; NaN is unknown.
  std::vector<float> occupancy;
};

struct MapImageOptions {
  /// Occupied from the first on, free up to the second, unknown between; part of the YAML file.
  double occupied_threshold = 0.65;
  double free_threshold = 0.196;
  WriteOptions file = {};
};

/// The cells of `map` within its bounds; a single unknown cell for an empty map. Of a map whose
/// bounds enclose more than 2^30 cells, as after a pose that diverged, those within 2048 cells of
/// the median of its tiles.
[[nodiscard]] GridImage grid_image(const OccupancyGrid& map);

/// The image for programs: 0 occupied, 254 free, 205 unknown, rows from the top.
[[nodiscard]] Result<std::string> format_pgm(const GridImage& grid,
                                             const MapImageOptions& options = {});
[[nodiscard]] std::string format_map_yaml(const GridImage& grid, const std::string& image_name,
                                          const MapImageOptions& options = {});

/// The image for viewing: grey by occupancy; unknown is a cool light grey.
[[nodiscard]] Image to_picture(const GridImage& grid);

using Colour = std::array<std::uint8_t, 3>;
inline constexpr Colour kBlue = {21, 101, 192};
inline constexpr Colour kRed = {211, 47, 47};
inline constexpr Colour kGreen = {46, 125, 50};

/// Draws on the image of a map; positions in metres, in the map's frame.
class MapPainter {
 public:
  explicit MapPainter(const GridImage& grid);

  /// A square with a side of `side` pixels. What is outside of the picture, or not finite, is not
  /// drawn; the same for `path`, and for its lines of more than 5e14 pixels.
  MapPainter& dot(const Eigen::Vector2d& position_m, const Colour& colour, int side = 2);
  /// Two pixels wide.
  MapPainter& path(std::span<const Eigen::Vector2d> positions_m, const Colour& colour);

  [[nodiscard]] const Image& picture() const { return picture_; }

 private:
  SE2d T_grid_map_;
  double resolution_m_;
  Image picture_;
};

/// Writes `stem`.pgm and `stem`.yaml.
[[nodiscard]] Result<void> write_map(const std::string& stem, const GridImage& grid,
                                     const MapImageOptions& options = {});

/// Reads a YAML file and its PGM, whose path is relative to the YAML file's folder. In `mode:
/// trinary` (and without a mode) cells are 0, 1 or unknown; in `mode: scale` they keep their grey
/// as a probability. Errors: missing or malformed keys (with the line), a damaged PGM or another
/// image type, `mode: raw`.
[[nodiscard]] Result<GridImage> read_map(const std::string& yaml_path,
                                         const ReadOptions& options = {});

/// The content of a map's YAML file.
struct MapYaml {
  std::string image;
  double resolution_m = 0.0;
  SE2d origin{};
  bool negate = false;
  bool scale = false;
  double occupied_threshold = 0.65;
  double free_threshold = 0.196;
};
[[nodiscard]] Result<MapYaml> parse_map_yaml(std::string_view text, const std::string& source);

/// A grey PGM image, binary (P5) or text (P2), with a maximum of at most 255, which is scaled to
/// 255.
[[nodiscard]] Result<Image> parse_pgm(std::string_view bytes, const std::string& source);

struct PointText {
  std::vector<Eigen::Vector3d> points_m;
  Problems problems;  ///< skipped lines
};

/// Empty lines and comments (#) are skipped, malformed lines reported by number and skipped.
/// Errors: the file cannot be read or contains no point.
[[nodiscard]] Result<PointText> read_points(const std::string& path);
[[nodiscard]] Result<PointText> parse_points(std::string_view text, const std::string& source);

}  // namespace wayfare::io
