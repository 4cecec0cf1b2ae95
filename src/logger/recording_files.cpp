#include "logger/recording_files.hpp"

#include <array>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <memory>
#include <system_error>
#include <utility>

namespace wayfare::logger {
namespace {

/// "recording-20260501T120000Z": sorts by time and is valid on any file system.
std::string name_by_time(const std::string& prefix, LogTime time) {
  const std::time_t seconds = time.nanoseconds() / 1'000'000'000;
  std::tm utc{};
  ::gmtime_r(&seconds, &utc);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y%m%dT%H%M%SZ", &utc);
  return prefix + "-" + text.data();
}

}  // namespace

bool RecordingFiles::rotates() const {
  return options_.rotate_bytes != 0 || options_.rotate_every > Duration(0);
}

std::string RecordingFiles::path_of(const std::string& base, std::uint32_t part) const {
  if (!rotates()) return base + ".mcap";
  std::array<char, 16> number{};
  std::snprintf(number.data(), number.size(), "_%04u", static_cast<unsigned>(part));
  return base + number.data() + ".mcap";
}

/// Without "_0001" and ".mcap", of a recording that does not exist.
std::string RecordingFiles::free_base() const {
  const std::string base =
      (std::filesystem::path(options_.folder) / name_by_time(options_.prefix, clock_.now()))
          .string();
  // Recordings that are started within one second.
  for (int n = 0; n < 100; ++n) {
    std::string name = base + (n == 0 ? "" : "-" + std::to_string(n));
    std::error_code ignored;
    if (!std::filesystem::exists(path_of(name, 1), ignored)) return name;
  }
  return {};
}

Result<io::McapWriter> RecordingFiles::create(const std::string& base, std::uint32_t part,
                                              const io::McapMetadata& about) const {
  io::McapWriterOptions how;
  how.library = "wayfare logger";
  const std::string path = path_of(base, part);
  std::error_code code;
  const bool there = std::filesystem::exists(path, code);
  auto writer = [&]() -> Result<io::McapWriter> {
    if (base.empty())
      return Error{ErrorCode::io, "there are a hundred recordings of this second already",
                   options_.folder};
    if (!options_.open_sink) return io::McapWriter::create(path, how);
    auto sink = options_.open_sink(path);
    if (!sink) return sink.error();
    return io::McapWriter::create(std::move(*sink), how);
  }();
  io::McapMetadata all = about;
  if (rotates()) all["part"] = std::to_string(part);
  Result<void> done = writer ? writer->add_metadata("logger", all) : writer.error();
  if (done) return writer;
  if (part > 1 && !there) {  // what is left of it is in the way of the next attempt
    writer = done.error();
    std::error_code ignored;
    std::filesystem::remove(path, ignored);
  }
  return done.error();
}

}  // namespace wayfare::logger
