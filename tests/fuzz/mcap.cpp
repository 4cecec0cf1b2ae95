// Bytes as a recording, and bytes as the recipe of one: chunks of every compression and messages
// outside of chunks, with or without a summary, then damaged. Each is read in every order, from
// memory and from a file, and every byte handed out is touched.

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <vector>

#include "io/mcap_parts.hpp"

namespace {

using namespace wayfare::io;
using namespace wayfare::testing;
using wayfare::LogTime;

constexpr int kMostParts = 12;
const McapReadOptions kOptions{std::size_t{1} << 22U, 10};

void require(bool holds) {
  if (!holds) std::abort();
}

/// A file without a place on the disk.
class MemoryFile {
 public:
  explicit MemoryFile(const std::string& bytes) : fd_(::memfd_create("fuzz", MFD_CLOEXEC)) {
    require(fd_ >= 0);
    require(::write(fd_, bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size()));
  }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  ~MemoryFile() { ::close(fd_); }
  [[nodiscard]] std::string path() const { return "/proc/self/fd/" + std::to_string(fd_); }

 private:
  int fd_;
};

std::vector<Remembered> by_time(std::vector<Remembered> all) {
  std::stable_sort(all.begin(), all.end(), [](const Remembered& a, const Remembered& b) {
    return a.log_time < b.log_time;
  });
  return all;
}

/// What is read in the order of the file.
std::vector<Remembered> read_every_way(const McapReader& reader) {
  const std::vector<Remembered> through = read_all(reader);
  const std::vector<Remembered> timed = read_all(reader, {McapOrder::log_time});
  if (!reader.contents().indexed) {
    // What was counted from the front is what is read, whatever the order.
    require(through.size() == reader.contents().statistics.messages);
    require(timed == by_time(through));
  }
  for (const McapOrder order : {McapOrder::file, McapOrder::log_time}) {
    std::size_t left = through.size() / 2;
    reader.read({order}, [&](const McapMessage& m) {
      require(m.channel != nullptr);
      return left-- > 0;
    });
  }
  return through;
}

std::vector<Remembered> read_from_both(const std::string& bytes) {
  const auto memory = McapReader::parse(bytes, "fuzz", kOptions);
  const MemoryFile file(bytes);
  const auto disk = McapReader::open(file.path(), kOptions);
  require(memory.has_value() == disk.has_value());
  if (!memory) return {};
  const std::vector<Remembered> all = read_every_way(*memory);
  require(read_every_way(*disk) == all);
  require(read_all(*disk, {McapOrder::log_time}) == read_all(*memory, {McapOrder::log_time}));
  return all;
}

class Recipe {
 public:
  Recipe(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}

  void cook() {
    const bool closed = next() % 2 == 0;
    const std::size_t damage = next() % 4;
    const std::string channel = mcap_channel("/fuzz");
    bytes_ = mcap_begin() + channel;
    for (int part = 0; part < kMostParts && size_ > 3 * damage; ++part) add_part();
    if (closed) bytes_ += mcap_end(bytes_.size(), channel, index_, wanted_.size(), chunks_, 0, 255);
    check(closed && !loose_);
    for (std::size_t i = 0; i < damage; ++i) {
      std::size_t at = next();
      at = at << 8U | next();
      bytes_[at % bytes_.size()] ^= static_cast<char>(next());
    }
    read_from_both(bytes_);
  }

 private:
  std::size_t next() {
    if (size_ == 0) return 0;
    --size_;
    return *data_++;
  }

  std::string message() {
    const auto number = static_cast<std::uint32_t>(wanted_.size());
    const auto time = LogTime::from_nanoseconds(static_cast<std::int64_t>(next()));
    const std::string text(next() % 80, static_cast<char>('a' + number % 26));
    wanted_.push_back({"/fuzz", text, number, time, LogTime()});
    return mcap_message(wanted_.back());
  }

  void add_part() {
    static constexpr const char* kNames[] = {"", "lz4", "zstd"};
    const std::size_t kind = next();
    if (kind % 4 == 3) {
      loose_ = true;
      bytes_ += message();
      return;
    }
    std::string records;
    std::uint64_t first = 255, last = 0;
    for (std::size_t i = 0; i < 1 + kind / 4 % 8; ++i) {
      records += message();
      const auto time = static_cast<std::uint64_t>(wanted_.back().log_time.nanoseconds());
      first = std::min(first, time), last = std::max(last, time);
    }
    const std::string chunk = mcap_chunk(kNames[kind % 4], records, first, last);
    index_ += mcap_chunk_index(first, last, bytes_.size(), chunk.size());
    bytes_ += chunk;
    ++chunks_;
  }

  void check(bool indexed) const {
    require(read_from_both(bytes_) == wanted_);
    const auto reader = McapReader::parse(bytes_, "fuzz", kOptions);
    require(reader->contents().indexed == indexed);
    require(read_all(*reader, {McapOrder::log_time}) == by_time(wanted_));
  }

  const std::uint8_t* data_;
  std::size_t size_;
  std::string bytes_, index_;
  std::vector<Remembered> wanted_;  ///< in the order they are written
  std::uint32_t chunks_ = 0;
  bool loose_ = false;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  if (bytes.starts_with("\x89MCAP")) {
    read_from_both(bytes);
  } else {
    Recipe(data, size).cook();
  }
  return 0;
}
