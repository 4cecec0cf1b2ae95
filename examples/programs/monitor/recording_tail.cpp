#include "recording_tail.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <string_view>

#include <wayfare/core/detail/bytes.hpp>

namespace wayfare::examples {
namespace {

constexpr std::string_view kMagic = "\x89MCAP0\r\n";
constexpr std::size_t kRecordHead = 9;  // opcode and length
constexpr std::size_t kMostRecord = std::size_t{1} << 26;
constexpr std::uint64_t kNew = std::uint64_t{1} << 20;  // no message of a smaller file is old
constexpr std::size_t kMostAtOnce = std::size_t{8} << 20;

// Opcodes of MCAP.
constexpr char kSchema = 3, kChannel = 4, kMessage = 5, kChunk = 6, kDataEnd = 15;

/// The records of an uncompressed chunk.
std::string_view records_of(std::string_view chunk) {
  constexpr std::size_t kBeforeCompression = kRecordHead + 28;
  if (chunk.size() < kBeforeCompression + 12) return {};
  if (decode::load_le<std::uint32_t>(chunk, kBeforeCompression) != 0) return {};
  return chunk.substr(kBeforeCompression + 12);
}

}  // namespace

bool RecordingTail::open() {
  if (file_.get() >= 0) return true;
  io::Descriptor file(::open(path_.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  struct stat about {};
  std::string magic;
  if (file.get() < 0 || ::fstat(file.get(), &about) != 0 || !S_ISREG(about.st_mode)) return false;
  std::swap(file_, file);
  if (!read(0, kMagic.size(), magic) || magic != kMagic) {
    std::swap(file_, file);
    return false;
  }
  next_ = kMagic.size();
  const auto size = static_cast<std::uint64_t>(about.st_size);
  old_until_ = size > kNew ? size : 0;
  described_ = magic;
  return true;
}

bool RecordingTail::read(std::uint64_t at, std::size_t size, std::string& to) const {
  to.resize(size);
  return ::pread(file_.get(), to.data(), size, static_cast<off_t>(at)) ==
         static_cast<ssize_t>(size);
}

bool RecordingTail::poll(const TailSink& sink) {
  if (ended_ || !open()) return false;
  std::string record;
  for (std::size_t done = 0; done < kMostAtOnce;) {
    if (!read(next_, kRecordHead, record)) return false;
    const char code = record[0];
    const auto length = decode::load_le<std::uint64_t>(record, 1);
    ended_ = code == kDataEnd || length > kMostRecord;
    if (ended_) return false;
    const std::size_t size = kRecordHead + static_cast<std::size_t>(length);
    if (!read(next_, size, record)) return false;
    if (code == kChunk || code == kSchema || code == kChannel || code == kMessage)
      take(record, sink);
    next_ += size;
    done += size;
    contents_.bytes = next_;
  }
  return true;
}

void RecordingTail::describe(std::string_view records) {
  while (records.size() >= kRecordHead) {
    const auto length = decode::load_le<std::uint64_t>(records, 1);
    if (length > records.size() - kRecordHead) return;
    const std::size_t size = kRecordHead + static_cast<std::size_t>(length);
    if (records[0] == kSchema || records[0] == kChannel) described_ += records.substr(0, size);
    records.remove_prefix(size);
  }
}

void RecordingTail::take(const std::string& record, const TailSink& sink) {
  // A file of the descriptions so far and this record.
  const auto file = io::McapReader::parse(described_ + record, path_);
  if (!file) return;
  describe(record[0] == kChunk ? records_of(record) : std::string_view(record));
  const io::McapContents& now = file->contents();
  contents_.schemas = now.schemas;
  contents_.channels = now.channels;
  auto& sum = contents_.statistics;
  sum.chunks += record[0] == kChunk ? 1 : 0;
  file->read({}, [&](const io::McapMessage& m) {
    sum.first = sum.messages == 0 ? m.log_time : std::min(sum.first, m.log_time);
    sum.last = sum.messages == 0 ? m.log_time : std::max(sum.last, m.log_time);
    ++sum.messages;
    ++sum.messages_of[m.channel->id];
    sink(m, next_ < old_until_);
    return true;
  });
}

}  // namespace wayfare::examples
