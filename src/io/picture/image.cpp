#include <wayfare/io/map_image.hpp>

#include <png.h>

#include <limits>

namespace wayfare::io {

Result<std::string> encode_png(const Image& image) {
  constexpr std::size_t kLargest = std::size_t{1} << 20;
  if (image.width == 0 || image.height == 0 || image.width > kLargest || image.height > kLargest)
    return Error{ErrorCode::invalid, "a picture of " + std::to_string(image.width) + " x " +
                                         std::to_string(image.height) + " pixels"};
  if (image.channels != 1 && image.channels != 3)
    return Error{ErrorCode::unsupported, "a picture has one channel or three"};
  if (image.pixels.size() != image.width * image.height * image.channels)
    return Error{ErrorCode::invalid, "the number of pixels does not match the picture's size"};
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = static_cast<png_uint_32>(image.width);
  png.height = static_cast<png_uint_32>(image.height);
  png.format = image.channels == 1 ? PNG_FORMAT_GRAY : PNG_FORMAT_RGB;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png);
  std::string bytes(size, '\0');
  if (png_image_write_to_memory(&png, bytes.data(), &size, 0, image.pixels.data(), 0, nullptr) == 0)
    return Error{ErrorCode::io, std::string("PNG: ") + png.message};
  bytes.resize(size);
  return bytes;
}

Result<void> write_png(const std::string& path, const Image& image, const WriteOptions& options) {
  const Result<std::string> bytes = encode_png(image);
  if (bytes) return write_file(path, *bytes, options);
  Error error = bytes.error();
  error.source = path;
  return error;
}

}  // namespace wayfare::io
