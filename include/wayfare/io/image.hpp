#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/io/text_file.hpp>

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

}  // namespace wayfare::io
