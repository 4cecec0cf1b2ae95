#pragma once

// Compressed blocks within recordings: LZ4 frames, Zstandard frames, bzip2 streams.

#include <cstdint>
#include <string>
#include <string_view>

#include <wayfare/core/result.hpp>

namespace wayfare::io {

/// The `size` bytes that `bytes` hold, compressed by `name`: "lz4", "zstd" or "bz2". Memory is
/// taken for `size` bytes. Errors: damaged, or not that many; a compression nobody knows, or that
/// this build was made without.
[[nodiscard]] Result<std::string> decompress_block(std::string_view name, std::string_view bytes,
                                                   std::uint64_t size);

}  // namespace wayfare::io
