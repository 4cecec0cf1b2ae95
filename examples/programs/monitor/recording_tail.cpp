#include "recording_tail.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <map>
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
  std::string record, records;
  const bool old = next_ < old_until_;
  const auto finish = [&](bool more) {
    if (!records.empty()) take(records, old, sink);
    return more;
  };
  for (std::size_t done = 0; done < kMostAtOnce && (next_ < old_until_) == old;) {
    if (!read(next_, kRecordHead, record)) return finish(false);
    const char code = record[0];
    const auto length = decode::load_le<std::uint64_t>(record, 1);
    ended_ = code == kDataEnd || length > kMostRecord;
    if (ended_) return finish(false);
    const std::size_t size = kRecordHead + static_cast<std::size_t>(length);
    if (!read(next_, size, record)) return finish(false);
    if (code == kChunk || code == kSchema || code == kChannel || code == kMessage)
      records += record;
    next_ += size;
    done += size;
    contents_.bytes = next_;
  }
  return finish(true);
}

void RecordingTail::describe(std::string_view records) {
  while (records.size() >= kRecordHead) {
    const auto length = decode::load_le<std::uint64_t>(records, 1);
    if (length > records.size() - kRecordHead) return;
    const std::string_view record =
        records.substr(0, kRecordHead + static_cast<std::size_t>(length));
    if (record[0] == kSchema || record[0] == kChannel) described_ += record;
    if (record[0] == kChunk) describe(records_of(record));
    records.remove_prefix(record.size());
  }
}

void RecordingTail::take(const std::string& records, bool old, const TailSink& sink) {
  // A file of the descriptions so far and these records.
  const auto file = io::McapReader::parse(described_ + records, path_);
  if (!file) return;
  describe(records);
  const io::McapContents& now = file->contents();
  contents_.schemas = now.schemas;
  contents_.channels = now.channels;
  auto& sum = contents_.statistics;
  sum.chunks += now.statistics.chunks;
  struct Last {
    io::McapMessage message;
    std::string data;
  };
  std::map<std::uint16_t, Last> last;  // by channel
  file->read({}, [&](const io::McapMessage& m) {
    sum.first = sum.messages == 0 ? m.log_time : std::min(sum.first, m.log_time);
    sum.last = sum.messages == 0 ? m.log_time : std::max(sum.last, m.log_time);
    ++sum.messages;
    ++sum.messages_of[m.channel->id];
    if (old) {
      last[m.channel->id] = {m, std::string(m.data)};
    } else {
      sink(m, false);
    }
    return true;
  });
  for (auto& [id, each] : last) {
    const auto channel = std::ranges::find(now.channels, id, &io::McapChannel::id);
    if (channel == now.channels.end()) continue;
    each.message.channel = &*channel;
    each.message.data = each.data;
    sink(each.message, true);
  }
}

}  // namespace wayfare::examples
