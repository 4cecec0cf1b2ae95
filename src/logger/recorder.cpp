#include "logger/recorder.hpp"

#include <sys/statvfs.h>

#include <array>
#include <ctime>
#include <filesystem>
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

LoggerClock::LoggerClock() {
  using std::chrono::nanoseconds;
  const auto utc = std::chrono::system_clock::now().time_since_epoch();
  const auto monotonic = std::chrono::steady_clock::now().time_since_epoch();
  offset_ = std::chrono::duration_cast<nanoseconds>(utc) -
            std::chrono::duration_cast<nanoseconds>(monotonic);
}

LogTime LoggerClock::now() const {
  const auto since = std::chrono::steady_clock::now().time_since_epoch();
  return LogTime() + std::chrono::duration_cast<Duration>(since) + offset_;
}

Recorder::Recorder(const LoggerOptions& options, const LoggerClock& clock)
    : options_(options), clock_(clock), queue_(options.queue_bytes) {
  thread_ = std::thread([this] { run(); });
}

Recorder::~Recorder() {
  stop();
  quit_ = true;
  queue_.push_always({});  // wakes it
  thread_.join();
}

Result<io::McapWriter> Recorder::create(std::string& path) const {
  io::McapWriterOptions how;
  how.library = "wayfare logger";
  const std::string base =
      (std::filesystem::path(options_.folder) / name_by_time(options_.prefix, clock_.now()))
          .string();
  // Two recordings started within one second.
  for (int n = 0; n < 100; ++n) {
    path = base;
    if (n != 0) path.append("-").append(std::to_string(n));
    path += ".mcap";
    std::error_code ignored;
    if (std::filesystem::exists(path, ignored)) continue;
    if (options_.open_sink) {
      auto sink = options_.open_sink(path);
      if (!sink) return sink.error();
      return io::McapWriter::create(std::move(*sink), how);
    }
    return io::McapWriter::create(path, how);
  }
  return Error{ErrorCode::io, "there are a hundred recordings of this second already", base};
}

Result<void> Recorder::begin(const io::McapMetadata& about) {
  {
    const std::lock_guard lock(state_mutex_);
    if (state_ == LoggerState::recording) return {};
    if (terminating_) return Error{ErrorCode::cancelled, "the logger is terminated"};
    if (state_ == LoggerState::stopping)
      return Error{ErrorCode::invalid, "the recording before is still being written", file_};
  }
  std::string path;
  auto writer = create(path);
  Result<void> done;
  if (!writer) done = writer.error();
  if (done) done = writer->add_metadata("logger", about);
  const std::lock_guard writing(writer_mutex_);
  const std::lock_guard lock(state_mutex_);
  file_ = path;
  error_ = done ? "" : done.error().to_string();
  begun_ = ended_ = clock_.now();
  written_ = 0;
  state_ = done ? LoggerState::recording : LoggerState::failed;
  state_changed_.notify_all();
  if (!done) return done;
  writer_.emplace(std::move(*writer));
  channels_.clear();
  schemas_.clear();
  flushed_ = synced_ = begun_;
  writer_session_ = ++sessions_;
  session_ = writer_session_;
  return {};
}

void Recorder::stop() {
  const std::uint32_t session = session_.exchange(0);
  {
    const std::lock_guard lock(state_mutex_);
    if (state_ == LoggerState::failed) state_ = LoggerState::idle;
    if (session != 0 && state_ == LoggerState::recording) state_ = LoggerState::stopping;
    state_changed_.notify_all();
  }
  if (session == 0) return;
  Item end;
  end.session = session;
  queue_.push_always(std::move(end));
}

void Recorder::terminate() {
  {
    const std::lock_guard lock(state_mutex_);
    terminating_ = true;
  }
  stop();
  const std::lock_guard lock(state_mutex_);
  if (state_ != LoggerState::stopping) state_ = LoggerState::terminated;
  state_changed_.notify_all();
}

bool Recorder::add(std::uint32_t session, const std::shared_ptr<const Stream>& stream,
                   LogTime logged, LogTime published, std::string data) {
  constexpr std::size_t kOverhead = sizeof(Item) + 32;
  const std::size_t cost = data.size() + kOverhead;
  return queue_.push({session, stream, logged, published, std::move(data)}, cost);
}

void Recorder::run() {
  while (!quit_) {
    const std::deque<Item> items = queue_.take(options_.flush_every);
    {
      const std::lock_guard writing(writer_mutex_);
      for (const Item& item : items) {
        handle(item);
        flush_if_due();
      }
      flush_if_due();
    }
    queue_.done();
  }
}

void Recorder::handle(const Item& item) {
  // What was read when the recording it was for had ended already belongs to none.
  if (!writer_ || item.session != writer_session_) return;
  if (item.stream == nullptr) {
    const auto closed = writer_->close();
    if (!closed) return end(LoggerState::failed, closed.error().to_string());
    return end(LoggerState::idle);
  }
  if (const auto done = write(item); !done) end(LoggerState::failed, done.error().to_string());
}

Result<void> Recorder::write(const Item& item) {
  const Stream& stream = *item.stream;
  auto channel = channels_.find(stream.topic);
  if (channel == channels_.end()) {
    std::uint16_t schema = 0;
    if (!stream.schema.empty()) {
      const auto known = schemas_.find(stream.schema);
      if (known != schemas_.end()) {
        schema = known->second;
      } else {
        const auto id = writer_->add_schema(stream.schema, "jsonschema", stream.schema_json);
        if (!id) return id.error();
        schema = schemas_[stream.schema] = *id;
      }
    }
    const auto id = writer_->add_channel(stream.topic, stream.encoding, schema, stream.metadata);
    if (!id) return id.error();
    channel = channels_.emplace(stream.topic, *id).first;
  }
  const LogTime published = std::max(item.published, LogTime());
  return writer_->write(channel->second, item.logged, published, item.data);
}

void Recorder::flush_if_due() {
  if (!writer_) return;
  const LogTime now = clock_.now();
  if (now - flushed_ < options_.flush_every) return;
  flushed_ = now;
  const bool sync = now - synced_ >= options_.sync_every;
  if (sync) synced_ = now;
  const auto done = sync ? writer_->sync() : writer_->flush();
  written_ = writer_->bytes_written();
  if (!done) end(LoggerState::failed, done.error().to_string());
}

void Recorder::end(LoggerState state, const std::string& error) {
  written_ = writer_->bytes_written();
  writer_.reset();
  std::uint32_t mine = writer_session_;
  session_.compare_exchange_strong(mine, 0);
  const std::lock_guard lock(state_mutex_);
  state_ = terminating_ ? LoggerState::terminated : state;
  error_ = error;
  ended_ = clock_.now();
  state_changed_.notify_all();
}

void Recorder::fill(LoggerStatus& status) const {
  const std::lock_guard lock(state_mutex_);
  status.state = state_;
  status.time = clock_.now();
  status.file = file_;
  status.error = error_;
  const bool running = state_ == LoggerState::recording || state_ == LoggerState::stopping;
  status.seconds = to_seconds((running ? status.time : ended_) - begun_);
  status.written = written_;
  status.queued = queue_.cost();
  status.queue_peak = queue_.peak();
  struct statvfs disk {};
  if (::statvfs(options_.folder.c_str(), &disk) == 0)
    status.disk_free = std::uint64_t{disk.f_bavail} * disk.f_frsize;
}

bool Recorder::wait_until_stopped(Duration timeout) {
  std::unique_lock lock(state_mutex_);
  return state_changed_.wait_for(lock, timeout, [&] {
    return state_ != LoggerState::recording && state_ != LoggerState::stopping;
  });
}

}  // namespace wayfare::logger
