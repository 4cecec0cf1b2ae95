#pragma once

// The writing thread: writes all data from the other threads in their order.

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <wayfare/io/mcap.hpp>
#include <wayfare/logger/detail/bounded_queue.hpp>
#include <wayfare/logger/logger.hpp>

#include "logger/clock_watch.hpp"
#include "logger/recording_files.hpp"

namespace wayfare::logger {

/// A timeout that can be added to the present time of any clock.
[[nodiscard]] inline Duration waitable(Duration timeout) {
  return std::clamp(timeout, Duration(0), Duration(std::chrono::hours(24 * 365)));
}

/// A message to be recorded.
struct LoggedMessage {
  std::size_t source = 0;  ///< number of its sensor; the logger itself comes behind the last
  bool raw = false;        ///< bytes as they were read
  std::shared_ptr<const Stream> stream;
  LogTime logged, published;
  std::string data;
};

/// What became of a source's messages in a recording.
struct Tally {
  std::uint64_t raw_bytes = 0;  ///< in the file
  std::uint64_t dropped = 0;    ///< messages that are not in the file
};

/// Between `begin` and its end a recording is one session: the queue has its messages, then one
/// mark of its end. The state leaves `recording` and `stopping` when the mark is met.
class Recorder {
 public:
  /// Every file begins with the messages that `head` gives.
  using Head = std::function<std::vector<LoggedMessage>()>;
  Recorder(const LoggerOptions& options, const LoggerClock& clock, Head head);
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;
  /// Writes all that is queued.
  ~Recorder();

  /// Begins a recording described by `about`. Error: it cannot be created. What stops it while its
  /// file is created ends it at once.
  Result<void> begin(const io::McapMetadata& about);
  void stop();
  void terminate();

  /// Which recording is being made, or has failed while its state still says `recording`; 0: none.
  [[nodiscard]] std::uint32_t session() const;
  /// Takes a message of recording `session`: it is written or counted as dropped. One of a session
  /// that has ended belongs to none. `always`: also where the queue is full.
  void add(std::uint32_t session, LoggedMessage message, bool always = false);

  /// Fills state, file, error, times and amounts; gives the tally of each source.
  [[nodiscard]] std::vector<Tally> fill(LoggerStatus& status) const;
  bool wait_until_stopped(Duration timeout);

 private:
  enum class Kind { message, end, quit };
  struct Item {
    Kind kind = Kind::message;
    LoggedMessage message = {};
  };
  /// Messages in the chunk that is not written yet.
  struct Pending {
    std::uint64_t raw_bytes = 0, messages = 0;
  };

  // These need `state_mutex_`.
  void halt();
  void close_session();

  // These need `writer_mutex_`.
  void handle(const Item& item);
  void rotate_if_due();
  void rotate(LogTime now);
  void flush_if_due();
  void open(io::McapWriter writer);
  Result<void> write(const LoggedMessage& message);
  void settle();
  void drop(std::size_t source);
  void fail(const Error& error);
  Result<void> close_file();
  void end();

  void run();

  const LoggerOptions& options_;
  const LoggerClock& clock_;
  const Head head_;
  const RecordingFiles names_;
  BoundedQueue<Item> queue_;

  std::mutex writer_mutex_;  ///< held while the disk works; taken before the other
  std::optional<io::McapWriter> writer_;
  std::map<std::string, std::uint16_t> channels_, schemas_;
  std::vector<Pending> pending_;  ///< by source
  std::uint32_t chunks_ = 0;      ///< in the file
  std::string base_;              ///< of the files' names
  std::uint32_t part_ = 0;        ///< number of the file
  io::McapMetadata about_;        ///< in each file
  std::uint64_t before_ = 0;      ///< bytes in the files before
  LogTime part_begun_, rotate_at_;
  std::string failure_;  ///< of this recording
  LogTime flushed_, synced_;

  mutable std::mutex state_mutex_;  ///< never held while the disk works
  std::condition_variable state_changed_;
  LoggerState state_ = LoggerState::idle;
  bool terminating_ = false;
  std::uint32_t session_ = 0, sessions_ = 0;
  std::uint32_t failed_session_ = 0;  ///< until its end mark: its messages are dropped
  std::vector<Tally> tallies_;        ///< by source
  std::uint64_t written_ = 0;
  std::string file_, error_, warning_;
  std::uint32_t files_ = 0;
  LogTime begun_, ended_;

  std::thread thread_;
};

}  // namespace wayfare::logger
