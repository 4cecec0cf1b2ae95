#pragma once

// Occupancy maps as PGM and YAML in the format of ROS map_server, and as images for viewing.
//
// Occupied voxels or points as text, one per line, in the format of ColoRadar's maps: "(x y z)" or
// "x,y,z", metres. Brackets, commas and blanks separate the numbers.

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <wayfare/core/result.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/map/occupancy_grid.hpp>

namespace wayfare::io {

/// Eight bits per channel, rows from the top, one (grey) or three (red, green, blue) channels.
struct Image {
  std::size_t width = 0;             ///< pixels
  std::size_t height = 0;            ///< pixels
  std::size_t channels = 1;          ///< 1 or 3
  std::vector<std::uint8_t> pixels;  ///< width · height · channels
};

/// A picture of three channels whose rows are made one at a time, so that it is never in memory as
/// a whole.
class PictureRows {
 public:
  /// Writes red, green and blue of the pixels of a row, from the top, to 3 · width bytes.
  using Draw = std::function<void(std::size_t row, std::span<std::uint8_t> pixels)>;

  /// `draw` is called for each row once, from the top, and must remain valid until then.
  PictureRows(std::size_t width, std::size_t height, Draw draw)
      : width_(width), height_(height), draw_(std::move(draw)) {}

  /// Pixels of a row.
  [[nodiscard]] std::size_t width() const { return width_; }
  /// Number of rows.
  [[nodiscard]] std::size_t height() const { return height_; }
  /// Makes a row below height().
  void draw(std::size_t row, std::span<std::uint8_t> pixels) const { draw_(row, pixels); }
  /// All rows.
  [[nodiscard]] Image image() const;

 private:
  std::size_t width_, height_;
  Draw draw_;
};

/// The picture with sides of at most `most_pixels`, at least one: each pixel is the mean of a
/// square, whose side is the least whole number of pixels. What `picture` draws must remain valid.
[[nodiscard]] PictureRows reduced(const PictureRows& picture, std::size_t most_pixels);

/// The bytes of a PNG file. Errors: no pixels, or inconsistent sizes.
[[nodiscard]] Result<std::string> encode_png(const Image& image);
/// The same of a picture made row by row.
[[nodiscard]] Result<std::string> encode_png(const PictureRows& picture);

/// Errors: those of encode_png; the file exists (see WriteOptions), or cannot be written.
[[nodiscard]] Result<void> write_png(const std::string& path, const Image& image,
                                     const WriteOptions& options = {});
/// The same of a picture made row by row.
[[nodiscard]] Result<void> write_png(const std::string& path, const PictureRows& picture,
                                     const WriteOptions& options = {});

/// A rectangle of cells. Cell (column, row) covers from (column, row) · resolution on, in the frame
/// whose pose in the map is `origin`: the lower left corner of the first cell.
struct GridImage {
  std::size_t width = 0;       ///< columns
  std::size_t height = 0;      ///< rows
  double resolution_m = 0.05;  ///< side of a cell
  SE2d origin{};               ///< of the first cell's lower left corner, in the map
  /// Probability that the cell is occupied, row by row from the lowest; NaN is unknown.
  std::vector<float> occupancy;
};

/// The cells of a map, read row by row without a copy of all. The map must outlive it.
class GridRows {
 public:
  /// Those of the image; none if their number does not match its size.
  GridRows(const GridImage& grid);  // NOLINT(google-explicit-constructor): a view
  /// Those that grid_image() gives.
  GridRows(const OccupancyGrid& map);  // NOLINT(google-explicit-constructor): a view

  /// Columns.
  [[nodiscard]] std::size_t width() const { return width_; }
  /// Rows.
  [[nodiscard]] std::size_t height() const { return height_; }
  /// Side of a cell.
  [[nodiscard]] double resolution_m() const { return resolution_m_; }
  /// Of the first cell's lower left corner, in the map.
  [[nodiscard]] const SE2d& origin() const { return origin_; }
  /// The occupancy of a row below height(), from the lowest, to width() numbers; NaN is unknown.
  void read(std::size_t row, std::span<float> occupancy) const;

 private:
  void read_tiles(std::size_t row, std::span<float> occupancy) const;

  std::size_t width_ = 0, height_ = 0;
  double resolution_m_;
  SE2d origin_;
  const GridImage* grid_ = nullptr;
  const OccupancyGrid* map_ = nullptr;
  CellBox box_{};                                          // of the map
  std::shared_ptr<const std::vector<float>> probability_;  // by fixed-point log-odds
};

/// Thresholds of the YAML file, and whether files are replaced.
struct MapImageOptions {
  /// Occupied from the first on, free up to the second, unknown between; part of the YAML file.
  double occupied_threshold = 0.65;
  double free_threshold = 0.196;  ///< see above
  WriteOptions file = {};         ///< of both files
};

/// The cells of `map` within its bounds; a single unknown cell for an empty map. Of a map whose
/// bounds enclose more than 2^30 cells, as after a pose that diverged, those within 2048 cells of
/// the median of its tiles.
[[nodiscard]] GridImage grid_image(const OccupancyGrid& map);
/// The cells of an image whose lower left corner has this pose in the frame of the grid.
/// Probabilities are limited to 0.001 and 0.999.
[[nodiscard]] OccupancyGrid occupancy_grid(const GridImage& image, const SE2d& T_grid_image = {});

/// The image for programs: 0 occupied, 254 free, 205 unknown, rows from the top.
[[nodiscard]] Result<std::string> format_pgm(const GridRows& grid,
                                             const MapImageOptions& options = {});
/// The YAML file of `image_name`.
[[nodiscard]] std::string format_map_yaml(const GridRows& grid, const std::string& image_name,
                                          const MapImageOptions& options = {});

/// The image for viewing: grey by occupancy; unknown is a cool light grey.
[[nodiscard]] Image to_picture(const GridRows& grid);
/// The same row by row; what `grid` views must outlive it.
[[nodiscard]] PictureRows picture_rows(const GridRows& grid);

using Colour = std::array<std::uint8_t, 3>;      ///< red, green, blue
inline constexpr Colour kBlue = {21, 101, 192};  ///< of estimates
inline constexpr Colour kRed = {211, 47, 47};    ///< of particles and marks
inline constexpr Colour kGreen = {46, 125, 50};  ///< of true paths

/// Draws on the image of a map; positions in metres, in the map's frame.
class MapPainter {
 public:
  /// On to_picture(grid). The map must outlive the painter and its rows().
  explicit MapPainter(const GridImage& grid) : grid_(grid) {}
  explicit MapPainter(const OccupancyGrid& map) : grid_(map) {}  ///< the same
  MapPainter(GridImage&&) = delete;
  MapPainter(OccupancyGrid&&) = delete;

  /// A square with a side of `side` pixels. What is outside of the picture, or not finite, is not
  /// drawn; the same for `path`, and for its lines of more than 5e14 pixels.
  MapPainter& dot(const Eigen::Vector2d& position_m, const Colour& colour, int side = 2);
  /// Two pixels wide.
  MapPainter& path(std::span<const Eigen::Vector2d> positions_m, const Colour& colour);

  /// With what was drawn.
  [[nodiscard]] Image picture() const { return rows().image(); }
  /// The same row by row; without what is drawn later.
  [[nodiscard]] PictureRows rows() const;

 private:
  struct Pixel {
    std::uint32_t row, column;  // from the top left
    Colour colour;
  };
  static void keep_last(std::vector<Pixel>& pixels);
  void add(double row, double column, const Colour& colour);

  GridRows grid_;
  std::vector<Pixel> drawn_;  // in the order drawn
  std::size_t sorted_ = 0;    // of these, by place
};

/// Writes `stem`.pgm and `stem`.yaml, the cells row by row.
[[nodiscard]] Result<void> write_map(const std::string& stem, const GridRows& grid,
                                     const MapImageOptions& options = {});

/// Reads a YAML file and its PGM, whose path is relative to the YAML file's folder. In `mode:
/// trinary` (and without a mode) cells are 0, 1 or unknown; in `mode: scale` they keep their grey
/// as a probability. Errors: missing or malformed keys (with the line), a damaged PGM or another
/// image type, `mode: raw`.
[[nodiscard]] Result<GridImage> read_map(const std::string& yaml_path,
                                         const ReadOptions& options = {});

/// The content of a map's YAML file.
struct MapYaml {
  std::string image;                 ///< path of the image
  double resolution_m = 0.0;         ///< side of a cell
  SE2d origin{};                     ///< of the lower left corner, in the map
  bool negate = false;               ///< dark is free
  bool scale = false;                ///< grey is a probability
  double occupied_threshold = 0.65;  ///< as of MapImageOptions
  double free_threshold = 0.196;     ///< as of MapImageOptions
};
/// Errors name `source` and the line.
[[nodiscard]] Result<MapYaml> parse_map_yaml(std::string_view text, const std::string& source);

/// A grey PGM image, binary (P5) or text (P2), with a maximum of at most 255, which is scaled to
/// 255.
[[nodiscard]] Result<Image> parse_pgm(std::string_view bytes, const std::string& source);

/// The points of a file.
struct PointText {
  std::vector<Eigen::Vector3d> points_m;  ///< m, in the order of the file
  Problems problems;                      ///< skipped lines
};

/// Empty lines and comments (#) are skipped, malformed lines reported by number and skipped.
/// Errors: the file cannot be read or contains no point.
[[nodiscard]] Result<PointText> read_points(const std::string& path);
/// The same for text in memory; `source` names it in messages.
[[nodiscard]] Result<PointText> parse_points(std::string_view text, const std::string& source);

}  // namespace wayfare::io
