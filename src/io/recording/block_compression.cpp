#include "io/recording/bytes.hpp"

#include <limits>
#include <optional>

#if WAYFARE_HAS_LZ4
#include <lz4frame.h>
#endif
#if WAYFARE_HAS_ZSTD
#include <zstd.h>
#endif
#if WAYFARE_HAS_BZIP2
#include <bzlib.h>
#endif

namespace wayfare::io {
namespace {

/// Fills `out`; false where `bytes` are damaged or do not decompress to its size.
using Decompress = bool (*)(std::string_view bytes, std::string& out);

#if WAYFARE_HAS_LZ4
bool from_lz4(std::string_view bytes, std::string& out) {
  LZ4F_dctx* context = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&context, LZ4F_VERSION)) != 0) return false;
  std::size_t written = 0, state = 1;
  while (state != 0) {
    std::size_t taken = bytes.size(), room = out.size() - written;
    state = LZ4F_decompress(context, out.data() + written, &room, bytes.data(), &taken, nullptr);
    if (LZ4F_isError(state) != 0 || (taken == 0 && room == 0)) break;
    bytes.remove_prefix(taken);
    written += room;
  }
  LZ4F_freeDecompressionContext(context);
  return state == 0 && written == out.size();
}
#else
constexpr Decompress from_lz4 = nullptr;
#endif

#if WAYFARE_HAS_ZSTD
bool from_zstd(std::string_view bytes, std::string& out) {
  const std::size_t n = ZSTD_decompress(out.data(), out.size(), bytes.data(), bytes.size());
  return ZSTD_isError(n) == 0 && n == out.size();
}
#else
constexpr Decompress from_zstd = nullptr;
#endif

#if WAYFARE_HAS_BZIP2
bool from_bz2(std::string_view bytes, std::string& out) {
  constexpr std::size_t kMax = std::numeric_limits<unsigned>::max();
  if (bytes.size() > kMax || out.size() > kMax) return false;
  auto n = static_cast<unsigned>(out.size());
  // The library does not write to its input.
  const int status = BZ2_bzBuffToBuffDecompress(out.data(), &n, const_cast<char*>(bytes.data()),
                                                static_cast<unsigned>(bytes.size()), 0, 0);
  return status == BZ_OK && n == out.size();
}
#else
constexpr Decompress from_bz2 = nullptr;
#endif

struct Known {
  std::string_view name, package;
  Decompress decompress;
};
constexpr Known kKnown[] = {{"lz4", "liblz4-dev", from_lz4},
                            {"zstd", "libzstd-dev", from_zstd},
                            {"bz2", "libbz2-dev", from_bz2}};

}  // namespace

Result<std::string> decompress_block(std::string_view name, std::string_view bytes,
                                     std::size_t size) {
  const std::string quoted = "is compressed by '" + std::string(name.substr(0, 16)) + "', ";
  for (const Known& known : kKnown) {
    if (known.name != name) continue;
    if (known.decompress == nullptr)
      return Error{ErrorCode::unsupported,
                   quoted + "which this build of wayfare does not support: install " +
                       std::string(known.package) + " and rebuild"};
    std::string out(size, '\0');
    if (known.decompress(bytes, out)) return out;
    return Error{ErrorCode::parse,
                 quoted + "but damaged, or not of " + std::to_string(size) + " bytes; skipped"};
  }
  return Error{ErrorCode::unsupported, quoted + "which is not supported; write it uncompressed"};
}

}  // namespace wayfare::io
