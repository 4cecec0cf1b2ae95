#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <limits>
#include <map>
#include <memory>
#include <system_error>
#include <utility>

#include <wayfare/io/text_file.hpp>

#include "io/text/text.hpp"

namespace wayfare::io {

int Descriptor::close() { return fd_ < 0 ? 0 : ::close(std::exchange(fd_, -1)); }

Error system_error(const std::string& what, const std::string& path) {
  return Error{ErrorCode::io, what + ": " + std::generic_category().message(errno), path};
}

namespace {

Error too_large(const std::string& source, std::size_t limit, const char* how) {
  return Error{
      ErrorCode::invalid,
      std::string(how) + " to more than the " + std::to_string(limit) + " bytes allowed; refused",
      source};
}

Result<std::string> read_raw(const std::string& path, std::size_t limit) {
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (file.get() < 0) return system_error("cannot be opened", path);
  struct stat status {};
  if (::fstat(file.get(), &status) != 0) return system_error("cannot be examined", path);
  if (S_ISDIR(status.st_mode)) return Error{ErrorCode::io, "is a folder, not a file", path};
  std::string bytes;
  std::size_t size = 0;
  bytes.resize(std::min(limit, static_cast<std::size_t>(status.st_size)) + 1);
  while (true) {
    if (size == bytes.size()) bytes.resize(size + std::max<std::size_t>(size / 2, 65536));
    const ssize_t got = ::read(file.get(), bytes.data() + size, bytes.size() - size);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return system_error("cannot be read", path);
    if (got == 0) break;
    size += static_cast<std::size_t>(got);
    if (size > limit) return too_large(path, limit, "comes");
  }
  bytes.resize(size);
  return bytes;
}

bool looks_like_gzip(std::string_view bytes) {
  return bytes.size() >= 2 && bytes[0] == '\x1f' && bytes[1] == '\x8b';
}

/// zlib's inflater over a byte string of any length.
class Inflater {
 public:
  explicit Inflater(std::string_view bytes) : rest_(bytes), total_(bytes.size()) {
    ready_ = inflateInit2(&stream_, 15 + 16) == Z_OK;
  }
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;
  ~Inflater() { inflateEnd(&stream_); }

  [[nodiscard]] bool ready() const { return ready_; }
  [[nodiscard]] std::string_view rest() const { return rest_; }
  [[nodiscard]] std::size_t offset() const { return total_ - rest_.size(); }
  bool restart() { return inflateReset(&stream_) == Z_OK; }

  /// zlib's return code; `written` is the number of bytes written to `out`.
  int step(char* out, std::size_t room, std::size_t& written) {
    constexpr std::size_t kMax = std::numeric_limits<uInt>::max();
    const std::size_t given = std::min(rest_.size(), kMax);
    // zlib takes its input through a pointer to non-const but does not write to it.
    stream_.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(rest_.data()));
    stream_.avail_in = static_cast<uInt>(given);
    stream_.next_out = reinterpret_cast<Bytef*>(out);
    stream_.avail_out = static_cast<uInt>(std::min(room, kMax));
    const uInt had = stream_.avail_out;
    const int code = inflate(&stream_, Z_NO_FLUSH);
    rest_.remove_prefix(given - stream_.avail_in);
    written = had - stream_.avail_out;
    return code;
  }

 private:
  z_stream stream_{};
  std::string_view rest_;
  std::size_t total_;
  bool ready_ = false;
};

}  // namespace

Result<FileContent> decompress(std::string_view bytes, const std::string& source,
                               const ReadOptions& options) {
  FileContent content;
  if (!looks_like_gzip(bytes)) {
    if (bytes.size() > options.max_bytes) return too_large(source, options.max_bytes, "comes");
    content.bytes = bytes;
    return content;
  }
  content.was_gzip = true;
  Inflater inflater(bytes);
  if (!inflater.ready()) return Error{ErrorCode::io, "no memory for decompression", source};
  const auto damaged = [&](const char* message) {
    content.damage = Error{ErrorCode::parse, message, source, 0, inflater.offset()};
  };
  constexpr std::size_t kChunk = std::size_t{1} << 18;
  const auto chunk = std::make_unique<char[]>(kChunk);
  while (true) {
    std::size_t written = 0;
    const int code = inflater.step(chunk.get(), kChunk, written);
    if (written > options.max_bytes - content.bytes.size())
      return too_large(source, options.max_bytes, "decompresses");
    content.bytes.append(chunk.get(), written);
    if (code == Z_STREAM_END) {
      const std::string_view rest = inflater.rest();
      if (rest.find_first_not_of('\0') == rest.npos) break;  // padding after the end is harmless
      if (!looks_like_gzip(rest) || !inflater.restart()) {
        damaged("something that is not gzip follows the compressed data");
        break;
      }
    } else if ((code == Z_OK || code == Z_BUF_ERROR) && written == 0 && inflater.rest().empty()) {
      damaged("the compressed data is cut off");
      break;
    } else if (code != Z_OK && (code != Z_BUF_ERROR || written == 0)) {
      damaged("the compressed data is damaged");
      break;
    }
  }
  return content;
}

Result<FileContent> read_file(const std::string& path, const ReadOptions& options) {
  Result<std::string> raw = read_raw(path, options.max_bytes);
  if (!raw) return raw.error();
  if (looks_like_gzip(*raw)) return decompress(*raw, path, options);
  FileContent content;
  content.bytes = std::move(*raw);
  return content;
}

namespace {

/// Moves leading digits of `text` to the end of `digits`; returns their number.
long take_digits(std::string_view& text, std::string& digits) {
  const std::size_t count = std::min(text.find_first_not_of("0123456789"), text.size());
  digits += text.substr(0, count);
  text.remove_prefix(count);
  return static_cast<long>(count);
}

/// The power of ten after 'e', 0 where there is none; nullopt where it is malformed.
std::optional<int> take_exponent(std::string_view text) {
  if (text.empty()) return 0;
  if (text.front() != 'e' && text.front() != 'E') return std::nullopt;
  int exponent = 0;
  if (!text::to_number(text.substr(1), exponent)) return std::nullopt;
  if (exponent < -1000 || exponent > 1000) return std::nullopt;
  return exponent;
}

/// 0.d1d2d3... · 10^places rounded to a whole number of at most `max`.
std::optional<std::uint64_t> rounded(const std::string& digits, long places, std::uint64_t max) {
  std::uint64_t value = 0;
  for (long i = 0; i < places; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const std::uint64_t digit = at < digits.size() ? static_cast<unsigned>(digits[at] - '0') : 0U;
    if (value > (max - digit) / 10) return std::nullopt;
    value = value * 10 + digit;
  }
  const bool up = places >= 0 && places < static_cast<long>(digits.size()) &&
                  digits[static_cast<std::size_t>(places)] >= '5';
  if (up && value == max) return std::nullopt;
  return value + (up ? 1 : 0);
}

}  // namespace

std::optional<std::int64_t> parse_nanoseconds(std::string_view seconds) {
  constexpr std::size_t kLongest = 400;  // limits the work on malformed input
  if (seconds.size() > kLongest) return std::nullopt;
  bool negative = false;
  if (!seconds.empty() && (seconds.front() == '-' || seconds.front() == '+')) {
    negative = seconds.front() == '-';
    seconds.remove_prefix(1);
  }
  std::string digits;
  long places = take_digits(seconds, digits);
  if (!seconds.empty() && seconds.front() == '.') {
    seconds.remove_prefix(1);
    take_digits(seconds, digits);
  }
  if (digits.empty()) return std::nullopt;
  const std::optional<int> exponent = take_exponent(seconds);
  if (!exponent) return std::nullopt;
  const std::size_t zeros = digits.find_first_not_of('0');
  if (zeros == digits.npos) return 0;
  places += *exponent + 9 - static_cast<long>(zeros);
  // The most negative number has no positive counterpart.
  constexpr auto kMax = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
  const auto value = rounded(digits.substr(zeros), places, negative ? kMax + 1 : kMax);
  if (!value) return std::nullopt;
  return static_cast<std::int64_t>(negative ? 0 - *value : *value);
}

std::string format_nanoseconds(std::int64_t nanoseconds) {
  const bool negative = nanoseconds < 0;
  // Unsigned, since the absolute value of the most negative number does not fit int64.
  const auto bits = static_cast<std::uint64_t>(nanoseconds);
  std::string text = std::to_string(negative ? 0 - bits : bits);
  if (text.size() < 10) text.insert(0, 10 - text.size(), '0');
  text.insert(text.size() - 9, 1, '.');
  return negative ? "-" + text : text;
}

std::string Problems::most_frequent() const {
  std::map<std::string, std::size_t> kinds;
  for (const Error& error : first_) {
    std::string kind = error.message.substr(0, error.message.find(':'));
    std::erase_if(kind, [](char c) { return c >= '0' && c <= '9'; });
    ++kinds[kind];
  }
  const auto most = std::max_element(
      kinds.begin(), kinds.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  return most == kinds.end() ? std::string() : most->first;
}

}  // namespace wayfare::io
