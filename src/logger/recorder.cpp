#include "logger/recorder.hpp"

#include <sys/statvfs.h>

#include <utility>

namespace wayfare::logger {
Recorder::Recorder(const LoggerOptions& options, const LoggerClock& clock, Head head)
    : options_(options),
      clock_(clock),
      head_(std::move(head)),
      names_(options, clock),
      queue_(options.queue_bytes),
      pending_(options.sensors.size() + 1),
      tallies_(options.sensors.size() + 1) {
  thread_ = std::thread([this] { run(); });
}

Recorder::~Recorder() {
  stop();
  queue_.push_always({Kind::quit});  // after everything there is to write
  thread_.join();
}

Result<void> Recorder::begin(const io::McapMetadata& about) {
  {
    std::unique_lock lock(state_mutex_);
    state_changed_.wait(lock, [&] { return state_ != LoggerState::starting; });
    if (state_ == LoggerState::recording) return {};
    if (terminating_) return Error{ErrorCode::cancelled, "the logger is terminated"};
    if (state_ == LoggerState::stopping)
      return Error{ErrorCode::invalid, "the recording before is still being written", file_};
    state_ = LoggerState::starting;
  }
  const std::string base = names_.free_base();
  auto writer = names_.create(base, 1, about);
  const Result<void> done = writer ? Result<void>() : writer.error();
  const std::lock_guard writing(writer_mutex_);
  const std::lock_guard lock(state_mutex_);
  file_ = names_.path_of(base, 1);
  files_ = done ? 1 : 0;
  error_ = done ? "" : done.error().to_string();
  warning_.clear();
  begun_ = ended_ = clock_.now();
  written_ = 0;
  tallies_.assign(tallies_.size(), {});
  state_changed_.notify_all();
  if (!done) {
    state_ = terminating_ ? LoggerState::terminated : LoggerState::failed;
    return done;
  }
  failure_.clear();
  base_ = base;
  part_ = 1;
  about_ = about;
  before_ = 0;
  part_begun_ = rotate_at_ = begun_;
  open(std::move(*writer));
  written_ = writer_->bytes_written();
  flushed_ = synced_ = begun_;
  session_ = ++sessions_;
  if (state_ == LoggerState::starting) {
    state_ = LoggerState::recording;
  } else {
    close_session();  // it was stopped meanwhile
  }
  return {};
}

void Recorder::open(io::McapWriter writer) {
  writer_.emplace(std::move(writer));
  channels_.clear();
  schemas_.clear();
  chunks_ = writer_->statistics().chunks;
  // A disk that fails is met by the next flush.
  for (const LoggedMessage& message : head_()) static_cast<void>(write(message));
}

void Recorder::close_session() {
  if (session_ == 0) return;
  session_ = 0;
  queue_.push_always({Kind::end});
}

void Recorder::halt() {
  if (state_ == LoggerState::failed) state_ = LoggerState::idle;
  if (state_ == LoggerState::starting || state_ == LoggerState::recording)
    state_ = LoggerState::stopping;
  close_session();
  failed_session_ = 0;
  state_changed_.notify_all();
}

void Recorder::stop() {
  const std::lock_guard lock(state_mutex_);
  halt();
}

void Recorder::terminate() {
  const std::lock_guard lock(state_mutex_);
  terminating_ = true;
  halt();
  if (state_ != LoggerState::stopping) state_ = LoggerState::terminated;
}

std::uint32_t Recorder::session() const {
  const std::lock_guard lock(state_mutex_);
  return session_ != 0 ? session_ : failed_session_;
}

void Recorder::add(std::uint32_t session, LoggedMessage message, bool always) {
  constexpr std::size_t kOverhead = sizeof(Item) + 32;
  const std::size_t source = message.source, cost = message.data.size() + kOverhead;
  // Under one lock with the check: no message of a session follows the mark of its end.
  const std::lock_guard lock(state_mutex_);
  if (session == 0) return;
  if (session == failed_session_) ++tallies_[source].dropped;
  if (session != session_) return;
  if (always) return queue_.push_always({Kind::message, std::move(message)});
  if (!queue_.push({Kind::message, std::move(message)}, cost)) ++tallies_[source].dropped;
}

void Recorder::run() {
  for (bool running = true; running;) {
    const std::deque<Item> items = queue_.take(waitable(options_.flush_every));
    {
      const std::lock_guard writing(writer_mutex_);
      for (const Item& item : items) {
        running = running && item.kind != Kind::quit;
        handle(item);
        flush_if_due();
        rotate_if_due();
      }
      flush_if_due();
      rotate_if_due();
    }
    queue_.done();
  }
}

void Recorder::handle(const Item& item) {
  if (item.kind == Kind::end) return end();
  if (item.kind == Kind::quit) return;
  const LoggedMessage& message = item.message;
  if (!writer_) return drop(message.source);
  if (const auto done = write(message); !done) {
    drop(message.source);
    return fail(done.error());
  }
  Pending& pending = pending_[message.source];
  pending.raw_bytes += message.raw ? message.data.size() : 0;
  ++pending.messages;
  settle();
}

void Recorder::drop(std::size_t source) {
  const std::lock_guard lock(state_mutex_);
  ++tallies_[source].dropped;
}

/// Counts what a chunk took to the file: it is written as a whole or not at all.
void Recorder::settle() {
  if (writer_->statistics().chunks == chunks_) return;
  chunks_ = writer_->statistics().chunks;
  const std::lock_guard lock(state_mutex_);
  written_ = before_ + writer_->bytes_written();
  for (std::size_t i = 0; i < pending_.size(); ++i)
    tallies_[i].raw_bytes += std::exchange(pending_[i], {}).raw_bytes;
}

Result<void> Recorder::write(const LoggedMessage& message) {
  const Stream& stream = *message.stream;
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
  const LogTime published = std::max(message.published, LogTime());
  return writer_->write(channel->second, message.logged, published, message.data);
}

void Recorder::flush_if_due() {
  if (!writer_) return;
  const LogTime now = clock_.now();
  if (now - flushed_ < options_.flush_every) return;
  flushed_ = now;
  const bool sync = now - synced_ >= options_.sync_every;
  if (sync) synced_ = now;
  const auto done = sync ? writer_->sync() : writer_->flush();
  settle();
  if (!done) fail(done.error());
}

void Recorder::rotate_if_due() {
  if (!writer_ || !names_.rotates()) return;
  const LogTime now = clock_.now();
  const bool large =
      options_.rotate_bytes != 0 && writer_->bytes_written() >= options_.rotate_bytes;
  const bool old =
      options_.rotate_every > Duration(0) && now - part_begun_ >= options_.rotate_every;
  if ((large || old) && now >= rotate_at_) rotate(now);
}

/// The next file exists before the last one is closed: where it cannot be created, that one goes
/// on.
void Recorder::rotate(LogTime now) {
  constexpr Duration kAgain = std::chrono::seconds(10);
  const auto flushed = writer_->flush();
  settle();
  if (!flushed) return fail(flushed.error());
  const std::string path = names_.path_of(base_, part_ + 1);
  auto next = names_.create(base_, part_ + 1, about_);
  if (!next) {
    rotate_at_ = now + kAgain;
    const std::lock_guard lock(state_mutex_);
    warning_ = "no next file: " + next.error().to_string();
    return;
  }
  // All data is in the file: without its index it is read from the front.
  static_cast<void>(close_file());
  before_ = written_;
  ++part_;
  part_begun_ = now;
  open(std::move(*next));
  const std::lock_guard lock(state_mutex_);
  written_ = before_ + writer_->bytes_written();
  file_ = path;
  files_ = part_;
  warning_.clear();
}

Result<void> Recorder::close_file() {
  auto done = writer_->close();
  settle();
  {
    const std::lock_guard lock(state_mutex_);
    written_ = before_ + writer_->bytes_written();
    for (std::size_t i = 0; i < pending_.size(); ++i)
      tallies_[i].dropped += std::exchange(pending_[i], {}).messages;
  }
  writer_.reset();
  return done;
}

/// What is queued is counted as dropped before the state says that the recording failed.
void Recorder::fail(const Error& error) {
  failure_ = error.to_string();
  static_cast<void>(close_file());
  const std::lock_guard lock(state_mutex_);
  failed_session_ = session_;
  close_session();
}

void Recorder::end() {
  if (writer_)
    if (const auto closed = close_file(); !closed) failure_ = closed.error().to_string();
  const std::lock_guard lock(state_mutex_);
  state_ = failure_.empty() ? LoggerState::idle : LoggerState::failed;
  if (terminating_) state_ = LoggerState::terminated;
  error_ = failure_;
  failed_session_ = 0;
  ended_ = clock_.now();
  state_changed_.notify_all();
}

std::vector<Tally> Recorder::fill(LoggerStatus& status) const {
  struct statvfs disk {};
  if (::statvfs(options_.folder.c_str(), &disk) == 0)
    status.disk_free = std::uint64_t{disk.f_bavail} * disk.f_frsize;
  const std::lock_guard lock(state_mutex_);
  status.state = state_;
  status.time = clock_.now();
  status.file = file_;
  status.files = files_;
  status.error = error_;
  status.warning = warning_;
  const bool running = state_ == LoggerState::recording || state_ == LoggerState::stopping;
  status.seconds = to_seconds((running ? status.time : ended_) - begun_);
  status.written = written_;
  status.queued = queue_.cost();
  status.queue_peak = queue_.peak();
  return tallies_;
}

bool Recorder::wait_until_stopped(Duration timeout) {
  std::unique_lock lock(state_mutex_);
  return state_changed_.wait_for(lock, waitable(timeout), [&] {
    return state_ != LoggerState::starting && state_ != LoggerState::recording &&
           state_ != LoggerState::stopping;
  });
}

}  // namespace wayfare::logger
