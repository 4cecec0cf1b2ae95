#pragma once

// Compressed blocks within recordings: LZ4 frames, Zstandard frames, bzip2 streams.

#include <cstdint>
#include <string>
#include <string_view>

#include <wayfare/core/result.hpp>

namespace wayfare::io {

/// Decompresses `bytes`, compressed by `name` ("lz4", "zstd" or "bz2"), to `size` bytes. Allocates
/// `size` bytes. Errors: damaged, or another size; a compression that is unknown or not supported
/// by this build.
[[nodiscard]] Result<std::string> decompress_block(std::string_view name, std::string_view bytes,
                                                   std::uint64_t size);

}  // namespace wayfare::io
