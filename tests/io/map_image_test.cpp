#include <wayfare/io/map_image.hpp>

#include <png.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <utility>

#include "support.hpp"

namespace wayfare::io {
namespace {

using ::testing::HasSubstr;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// Occupied at the lower left, free at the upper right, the rest unknown.
GridImage small() {
  return {3, 2, 0.05, SE2d(-1.5, 2.25, Angle::radians(0.5)), {0.9F, 0.5F, kNan, kNan, 0.4F, 0.1F}};
}

TEST(MapImage, PgmGolden) {
  // The upper row comes first.
  const std::string expected =
      std::string("P5\n3 2\n255\n") + "\xcd\xcd\xfe" + std::string(1, '\0') + "\xcd\xcd";
  EXPECT_EQ(*format_pgm(small()), expected);
}

TEST(MapImage, YamlGolden) {
  EXPECT_EQ(format_map_yaml(small(), "it's.pgm"),
            "image: 'it''s.pgm'\nresolution: 0.05\norigin: [-1.5, 2.25, 0.5]\nnegate: 0\n"
            "occupied_thresh: 0.65\nfree_thresh: 0.196\n");
}

TEST(MapImage, RoundTrip) {
  const testing::TemporaryFolder folder;
  ASSERT_TRUE(write_map(folder / "it's a map", small()));
  EXPECT_FALSE(write_map(folder / "it's a map", small()));  // it exists
  const Result<GridImage> map = read_map(folder / "it's a map.yaml");
  ASSERT_TRUE(map) << map.error().to_string();
  EXPECT_EQ(map->width, 3U);
  EXPECT_EQ(map->height, 2U);
  EXPECT_EQ(map->resolution_m, 0.05);
  EXPECT_LT(map->origin.minus(small().origin).norm(), 1e-12);
  EXPECT_EQ(map->occupancy[0], 1.0F);
  EXPECT_EQ(map->occupancy[5], 0.0F);
  for (const std::size_t i : {1U, 2U, 3U, 4U}) EXPECT_TRUE(std::isnan(map->occupancy[i])) << i;
}

TEST(MapImage, ReadsOtherWritersFiles) {
  const testing::TemporaryFolder folder;
  ASSERT_TRUE(write_file(folder / "m.pgm", "P2 # text\n# comment\n2 1\n100\n0 100\n"));
  ASSERT_TRUE(write_file(folder / "m.yaml",
                         "---\nimage: m.pgm  # beside\nresolution: 0.1\norigin: [1,2, 0.0]\n"
                         "negate: 1\nmode: scale\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"));
  const Result<GridImage> map = read_map(folder / "m.yaml");
  ASSERT_TRUE(map) << map.error().to_string();
  EXPECT_EQ(map->occupancy[0], 0.0F);
  EXPECT_EQ(map->occupancy[1], 1.0F);
}

TEST(MapImage, MalformedPicturesAndYaml) {
  const std::pair<std::string, const char*> pictures[] = {
      {"", "not a PGM"},
      {"P6 1 1 255\nabc", "not a PGM"},
      {"\x89PNG\r\n", "convert the PNG to PGM"},
      {"P5 0 1 255\n", "not a size: '0'"},
      {"P5 x 1 255\n", "not a size: 'x'"},
      {"P5 3 2 255\n12345", "cut off"},
      {"P5 1048576 1048576 255\n1", "cut off"},
      {"P5 1 1 65535\n12", "8 bits"},
      {"P2 2 1 255\n1 y", "pixel 1: not a number: 'y'"},
  };
  for (const auto& [bytes, message] : pictures) {
    const Result<Image> image = parse_pgm(bytes, "m.pgm");
    ASSERT_FALSE(image) << bytes;
    EXPECT_THAT(image.error().to_string(), HasSubstr(message));
  }
  const std::string good = "image: m.pgm\nresolution: 0.1\n";
  const std::pair<std::string, const char*> yamls[] = {
      {"", "'image' is missing"},
      {"image: m.pgm\n", "'resolution' is missing"},
      {"image: m.pgm\nresolution: -1\n", "m.yaml:2: 'resolution' must be a positive number"},
      {good, "'origin' is missing"},
      {good + "origin: [1, 2]\n", "m.yaml:3: 'origin' must be [x, y, heading]"},
      {good + "origin: [1, 2, nan]\n", "m.yaml:3"},
      {good + "origin: [1, 2, 0]\nmode: raw\n", "m.yaml:4: 'mode' must be trinary or scale"},
      {good + "origin: [1, 2, 0]\nfree_thresh: x\n", "m.yaml:4: 'free_thresh' must be a number"},
      {good + "rubbish\n", "m.yaml:3: not 'key: value'; expected the .yaml file of a map"},
      {"P5\n2 2\n255\n", "m.yaml: is a picture; expected the .yaml file of a map"},
      {"\x89PNG\r\n", "m.yaml: is a picture"},
  };
  for (const auto& [text, message] : yamls) {
    const Result<MapYaml> yaml = parse_map_yaml(text, "m.yaml");
    ASSERT_FALSE(yaml) << text;
    EXPECT_THAT(yaml.error().to_string(), HasSubstr(message));
  }
}

/// libpng's own reader as reference.
std::vector<std::uint8_t> decoded(const std::string& bytes, png_uint_32 format, Image& size) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  EXPECT_NE(png_image_begin_read_from_memory(&png, bytes.data(), bytes.size()), 0);
  png.format = format;
  std::vector<std::uint8_t> pixels(PNG_IMAGE_SIZE(png));
  EXPECT_NE(png_image_finish_read(&png, nullptr, pixels.data(), 0, nullptr), 0);
  size.width = png.width;
  size.height = png.height;
  return pixels;
}

TEST(Png, RoundTripOfGreyAndColour) {
  Image size;
  const Image grey{3, 2, 1, {0, 50, 100, 150, 200, 255}};
  EXPECT_EQ(decoded(*encode_png(grey), PNG_FORMAT_GRAY, size), grey.pixels);
  EXPECT_EQ(size.width, 3U);
  EXPECT_EQ(size.height, 2U);
  const Image colour{1, 2, 3, {255, 0, 0, 1, 2, 3}};
  EXPECT_EQ(decoded(*encode_png(colour), PNG_FORMAT_RGB, size), colour.pixels);
}

TEST(Png, RejectsInvalidPictures) {
  EXPECT_FALSE(encode_png({}));
  EXPECT_FALSE(encode_png({2, 2, 1, {1, 2, 3}}));
  EXPECT_FALSE(encode_png({1, 1, 2, {1, 2}}));
}

/// Red counts the pixels from 10, green is their row, blue 255.
PictureRows counted(std::size_t width, std::size_t height) {
  return {width, height, [width](std::size_t row, std::span<std::uint8_t> pixels) {
            for (std::size_t i = 0; i < width; ++i) {
              pixels[3 * i] = static_cast<std::uint8_t>(10 + row * width + i);
              pixels[3 * i + 1] = static_cast<std::uint8_t>(row);
              pixels[3 * i + 2] = 255;
            }
          }};
}

TEST(PictureRows, ReducedIsTheMeanOfSquaresAlsoOfThoseCutOff) {
  // 10 11 12 / 13 14 15 / 16 17 18 by squares of two: means of 10 11 13 14 (12), 12 15 (13.5, away
  // from zero), 16 17 (16.5) and 18; rows are 0.5 and 2.
  const Image small = reduced(counted(3, 3), 2).image();
  EXPECT_EQ(small.width, 2U);
  EXPECT_EQ(small.height, 2U);
  EXPECT_THAT(small.pixels, ::testing::ElementsAre(12, 1, 255, 14, 1, 255, 17, 2, 255, 18, 2, 255));
}

TEST(PictureRows, ReducedHasAtMostThePixelsAskedForAndIsTheSameIfItHasFewer) {
  EXPECT_EQ(reduced(counted(7, 4), 7).image().pixels, counted(7, 4).image().pixels);
  for (const std::size_t most : {0U, 1U, 2U, 3U, 6U}) {
    const PictureRows small = reduced(counted(7, 4), most);
    EXPECT_LE(std::max(small.width(), small.height()), std::max<std::size_t>(most, 1)) << most;
    EXPECT_GE(small.height(), 1U);
  }
  EXPECT_EQ(reduced(counted(0, 0), 5).width(), 0U);
}

TEST(MapImage, PictureIsTopDownAndColoursTheUnknown) {
  const Image picture = to_picture(small());
  ASSERT_EQ(picture.pixels.size(), 18U);
  EXPECT_EQ(picture.pixels[6], std::lround(255 * 0.9));  // upper right: free
  EXPECT_EQ(picture.pixels[9], std::lround(255 * 0.1));  // lower left: occupied
  EXPECT_NE(picture.pixels[0], picture.pixels[2]);       // unknown is not grey
}

}  // namespace
}  // namespace wayfare::io
