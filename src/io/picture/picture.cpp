#include <png.h>

#include <algorithm>
#include <cmath>
#include <csetjmp>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/core/statistics.hpp>
#include <wayfare/io/map_image.hpp>

namespace wayfare::io {
namespace {

/// Writes a PNG file row by row. libpng reports faults by longjmp: nothing with a destructor may be
/// created between `guarded` and the fault.
class PngWriter {
 public:
  PngWriter()
      : png_(png_create_write_struct(PNG_LIBPNG_VER_STRING, this, &fail, &warn)),
        info_(png_ == nullptr ? nullptr : png_create_info_struct(png_)) {
    if (png_ != nullptr) png_set_write_fn(png_, this, &append, &flush);
  }
  PngWriter(const PngWriter&) = delete;
  PngWriter& operator=(const PngWriter&) = delete;
  ~PngWriter() { png_destroy_write_struct(&png_, &info_); }

  [[nodiscard]] bool begin(std::size_t width, std::size_t height, int colour_type) {
    return info_ != nullptr && guarded([&] {
             png_set_IHDR(png_, info_, static_cast<png_uint_32>(width),
                          static_cast<png_uint_32>(height), 8, colour_type, PNG_INTERLACE_NONE,
                          PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
             png_set_sRGB(png_, info_, PNG_sRGB_INTENT_PERCEPTUAL);
             png_write_info(png_, info_);
           });
  }
  [[nodiscard]] bool row(const std::uint8_t* pixels) {
    return guarded([&] { png_write_row(png_, pixels); });
  }
  [[nodiscard]] bool end() {
    return guarded([&] { png_write_end(png_, info_); });
  }
  [[nodiscard]] Error fault() const { return {ErrorCode::io, "PNG: " + fault_}; }
  [[nodiscard]] std::string bytes() && { return std::move(bytes_); }

 private:
  template <class Calls>
  bool guarded(const Calls& calls) {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    calls();
    return true;
  }
  static void fail(png_structp png, png_const_charp message) {
    static_cast<PngWriter*>(png_get_error_ptr(png))->fault_ = message;
    png_longjmp(png, 1);
  }
  static void warn(png_structp, png_const_charp) {}
  static void append(png_structp png, png_bytep bytes, std::size_t count) {
    static_cast<PngWriter*>(png_get_io_ptr(png))
        ->bytes_.append(reinterpret_cast<const char*>(bytes), count);
  }
  static void flush(png_structp) {}

  std::string bytes_, fault_ = "out of memory";
  png_structp png_;
  png_infop info_;
};

/// `row(i)` is the i-th row's pixels.
template <class Row>
Result<std::string> encode(std::size_t width, std::size_t height, int colour_type, const Row& row) {
  constexpr std::size_t kLargest = std::size_t{1} << 20;
  if (width == 0 || height == 0 || width > kLargest || height > kLargest)
    return Error{ErrorCode::invalid, "a picture of " + std::to_string(width) + " x " +
                                         std::to_string(height) + " pixels"};
  PngWriter writer;
  bool written = writer.begin(width, height, colour_type);
  for (std::size_t i = 0; written && i < height; ++i) written = writer.row(row(i));
  if (!written || !writer.end()) return writer.fault();
  return std::move(writer).bytes();
}

Result<void> write_encoded(const std::string& path, const Result<std::string>& bytes,
                           const WriteOptions& options) {
  if (bytes) return write_file(path, *bytes, options);
  Error error = bytes.error();
  error.source = path;
  return error;
}

/// The bounds, or a part of them that can be kept in memory.
CellBox bounds_of(const OccupancyGrid& map) {
  constexpr int kReach = 2048;
  const CellBox box = map.bounds().value_or(CellBox{});
  if (box.cells() <= std::int64_t{1} << 30) return box;
  std::vector<int> x, y;
  map.for_each_tile([&](const Cell& first, const auto&) {
    x.push_back(first.x);
    y.push_back(first.y);
  });
  const Cell middle{upper_median_of(x), upper_median_of(y)};
  return {{std::max(box.min.x, middle.x - kReach), std::max(box.min.y, middle.y - kReach)},
          {std::min(box.max.x, middle.x + kReach), std::min(box.max.y, middle.y + kReach)}};
}

/// Probabilities by fixed-point log-odds, from the least.
std::vector<float> probabilities() {
  constexpr int kLeast = std::numeric_limits<std::int16_t>::min();
  constexpr int kMost = std::numeric_limits<std::int16_t>::max();
  std::vector<float> table(kMost - kLeast + 1, std::nanf(""));
  for (int l = OccupancyGrid::kUnknown + 1; l <= kMost; ++l)
    table[static_cast<std::size_t>(l - kLeast)] =
        static_cast<float>(LogOdds{static_cast<std::int16_t>(l)}.probability());
  return table;
}

bool is_consistent(const GridImage& grid) {
  return grid.width > 0 && grid.height > 0 && grid.occupancy.size() / grid.width == grid.height &&
         grid.occupancy.size() % grid.width == 0;
}

}  // namespace

Image PictureRows::image() const {
  Image image{width_, height_, 3, {}};
  image.pixels.resize(3 * width_ * height_);
  for (std::size_t row = 0; row < height_; ++row)
    draw(row, std::span(image.pixels).subspan(3 * width_ * row, 3 * width_));
  return image;
}

PictureRows reduced(const PictureRows& picture, std::size_t most_pixels) {
  const std::size_t longest = std::max(picture.width(), picture.height());
  const std::size_t most = std::max<std::size_t>(most_pixels, 1);
  const std::size_t side = (longest + most - 1) / most;
  if (side < 2) return picture;
  const auto draw = [=](std::size_t row, std::span<std::uint8_t> pixels) {
    std::vector<std::uint8_t> line(3 * picture.width());
    std::vector<std::size_t> sums(pixels.size());
    const std::size_t first = row * side, end = std::min(first + side, picture.height());
    for (std::size_t r = first; r < end; ++r) {
      picture.draw(r, line);
      for (std::size_t x = 0; x < picture.width(); ++x)
        for (std::size_t c = 0; c < 3; ++c) sums[3 * (x / side) + c] += line[3 * x + c];
    }
    for (std::size_t i = 0; i < sums.size(); ++i) {
      const std::size_t columns = std::min(side, picture.width() - i / 3 * side);
      const std::size_t count = std::max<std::size_t>(columns * (end - first), 1);
      pixels[i] = static_cast<std::uint8_t>((sums[i] + count / 2) / count);
    }
  };
  return {(picture.width() + side - 1) / side, (picture.height() + side - 1) / side, draw};
}

Result<std::string> encode_png(const Image& image) {
  if (image.channels != 1 && image.channels != 3)
    return Error{ErrorCode::unsupported, "a picture has one channel or three"};
  const std::size_t row_bytes = image.width * image.channels;
  if (image.pixels.size() != row_bytes * image.height)
    return Error{ErrorCode::invalid, "the number of pixels does not match the picture's size"};
  return encode(image.width, image.height,
                image.channels == 1 ? PNG_COLOR_TYPE_GRAY : PNG_COLOR_TYPE_RGB,
                [&](std::size_t row) { return image.pixels.data() + row * row_bytes; });
}

Result<std::string> encode_png(const PictureRows& picture) {
  std::vector<std::uint8_t> pixels(3 * picture.width());
  return encode(picture.width(), picture.height(), PNG_COLOR_TYPE_RGB, [&](std::size_t row) {
    picture.draw(row, pixels);
    return pixels.data();
  });
}

Result<void> write_png(const std::string& path, const Image& image, const WriteOptions& options) {
  return write_encoded(path, encode_png(image), options);
}

Result<void> write_png(const std::string& path, const PictureRows& picture,
                       const WriteOptions& options) {
  return write_encoded(path, encode_png(picture), options);
}

GridRows::GridRows(const GridImage& grid)
    : resolution_m_(grid.resolution_m), origin_(grid.origin), grid_(&grid) {
  if (!is_consistent(grid)) return;
  width_ = grid.width;
  height_ = grid.height;
}

GridRows::GridRows(const OccupancyGrid& map)
    : resolution_m_(map.resolution_m()), map_(&map), box_(bounds_of(map)) {
  static const auto kProbabilities = std::make_shared<const std::vector<float>>(probabilities());
  probability_ = kProbabilities;
  width_ = static_cast<std::size_t>(box_.width());
  height_ = static_cast<std::size_t>(box_.height());
  // Rounded to the nanometre, since the product may be -1.4000000000000001 instead of -1.4.
  const auto metres = [&](int cells) { return std::round(cells * resolution_m_ * 1e9) / 1e9; };
  origin_ = SE2d(metres(box_.min.x), metres(box_.min.y), Angle{});
}

void GridRows::read(std::size_t row, std::span<float> occupancy) const {
  if (map_ != nullptr) return read_tiles(row, occupancy);
  std::copy_n(grid_->occupancy.begin() + static_cast<std::ptrdiff_t>(row * width_), width_,
              occupancy.begin());
}

void GridRows::read_tiles(std::size_t row, std::span<float> occupancy) const {
  std::fill(occupancy.begin(), occupancy.end(), std::nanf(""));
  const int y = box_.min.y + static_cast<int>(row);
  map_->for_each_row({{box_.min.x, y}, {box_.max.x, y}}, [&](const Cell& first,
                                                             std::span<const std::int16_t> cells) {
    auto to = occupancy.begin() + (first.x - box_.min.x);
    for (const std::int16_t l : cells)
      *to++ =
          (*probability_)[static_cast<std::size_t>(l - std::numeric_limits<std::int16_t>::min())];
  });
}

GridImage grid_image(const OccupancyGrid& map) {
  const GridRows rows(map);
  GridImage image{rows.width(), rows.height(), rows.resolution_m(), rows.origin(), {}};
  image.occupancy.resize(image.width * image.height);
  for (std::size_t row = 0; row < image.height; ++row)
    rows.read(row, std::span(image.occupancy).subspan(row * image.width, image.width));
  return image;
}

OccupancyGrid occupancy_grid(const GridImage& image, const SE2d& T_grid_image) {
  OccupancyGrid grid({.resolution_m = image.resolution_m});
  for (std::size_t row = 0; row < image.height; ++row)
    for (std::size_t column = 0; column < image.width; ++column) {
      const auto p = static_cast<double>(image.occupancy[row * image.width + column]);
      if (std::isnan(p)) continue;
      const Eigen::Vector2d centre(static_cast<double>(column) + 0.5,
                                   static_cast<double>(row) + 0.5);
      grid.update(cell_of(T_grid_image * (image.resolution_m * centre), image.resolution_m),
                  LogOdds::from_probability(std::clamp(p, 0.001, 0.999)));
    }
  return grid;
}

PictureRows picture_rows(const GridRows& grid) {
  return {grid.width(), grid.height(),
          [grid, occupancy = std::vector<float>(grid.width())](
              std::size_t row, std::span<std::uint8_t> pixels) mutable {
            constexpr std::uint8_t kUnknown[] = {206, 212, 218};
            grid.read(grid.height() - 1 - row, occupancy);
            auto to = pixels.begin();
            for (const float p : occupancy) {
              const float light = 255.0F * (1.0F - std::clamp(p, 0.0F, 1.0F));
              if (std::isnan(p)) {
                to = std::copy(std::begin(kUnknown), std::end(kUnknown), to);
              } else {
                to = std::fill_n(to, 3, static_cast<std::uint8_t>(std::lround(light)));
              }
            }
          }};
}

Image to_picture(const GridRows& grid) { return picture_rows(grid).image(); }

}  // namespace wayfare::io
