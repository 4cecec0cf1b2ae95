#pragma once

// The writing thread: writes all data from the other threads in their order.

#include <atomic>
#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include <wayfare/io/mcap.hpp>
#include <wayfare/logger/detail/bounded_queue.hpp>
#include <wayfare/logger/logger.hpp>

namespace wayfare::logger {

/// The clock of all stamps.
class LoggerClock {
 public:
  LoggerClock();
  [[nodiscard]] LogTime now() const;

 private:
  std::chrono::nanoseconds offset_;  ///< UTC minus the monotonic clock
};

class Recorder {
 public:
  Recorder(const LoggerOptions& options, const LoggerClock& clock);
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;
  ~Recorder();

  /// Begins a recording described by `about`. Error: it cannot be created.
  Result<void> begin(const io::McapMetadata& about);
  void stop();
  void terminate();

  /// Which recording is being made; 0: none.
  [[nodiscard]] std::uint32_t session() const { return session_; }
  /// Takes a message of recording `session`; false where the queue has no room for it.
  [[nodiscard]] bool add(std::uint32_t session, const std::shared_ptr<const Stream>& stream,
                         LogTime logged, LogTime published, std::string data);

  /// State, file, error, times and amounts.
  void fill(LoggerStatus& status) const;
  bool wait_until_stopped(Duration timeout);

 private:
  struct Item {
    std::uint32_t session = 0;
    std::shared_ptr<const Stream> stream;  ///< none: the recording's end
    LogTime logged, published;
    std::string data;
  };

  void run();
  void handle(const Item& item);
  void flush_if_due();
  Result<void> write(const Item& item);
  void end(LoggerState state, const std::string& error = {});
  Result<io::McapWriter> create(std::string& path) const;
  void set_state(LoggerState state);

  const LoggerOptions& options_;
  const LoggerClock& clock_;
  BoundedQueue<Item> queue_;
  std::atomic<std::uint32_t> session_{0};
  std::atomic<bool> quit_{false};
  std::atomic<std::uint64_t> written_{0};

  std::mutex writer_mutex_;  ///< held while the disk works
  std::optional<io::McapWriter> writer_;
  std::uint32_t writer_session_ = 0;
  std::map<std::string, std::uint16_t> channels_, schemas_;
  LogTime flushed_, synced_;

  mutable std::mutex state_mutex_;
  std::condition_variable state_changed_;
  LoggerState state_ = LoggerState::idle;
  bool terminating_ = false;
  std::uint32_t sessions_ = 0;
  std::string file_, error_;
  LogTime begun_, ended_;

  std::thread thread_;
};

}  // namespace wayfare::logger
