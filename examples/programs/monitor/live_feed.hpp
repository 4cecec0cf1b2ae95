#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "live_link.hpp"
#include "recording_tail.hpp"

namespace wayfare::examples {

/// What a running logger says and records, as server-sent events for any number of listeners: its
/// statuses, why there are none, the contents of the recording, and its messages as they are
/// written. A new listener gets those of the last moments; one that falls behind gets the newest
/// message of each topic, and how many it missed; the memory does not depend on the number and
/// speed of the listeners.
class LiveFeed {
 public:
  explicit LiveFeed(const LiveLink& link) : link_(link), thread_([this] { run(); }) {}
  LiveFeed(const LiveFeed&) = delete;
  LiveFeed& operator=(const LiveFeed&) = delete;
  ~LiveFeed() { stop(); }

  /// What one listener has got.
  struct Listener {
    std::set<std::string> topics = {};                ///< of the messages it wants
    std::uint64_t seen = 0;                           ///< number of the last event
    std::map<std::string, std::uint64_t> count = {};  ///< of the messages of a topic up to it
    std::map<std::string, std::uint64_t> missed = {};
  };
  /// The events since the last call; empty if there are none until `timeout`, or after `stop`.
  [[nodiscard]] std::string wait(Listener& listener, std::chrono::milliseconds timeout) const;
  /// Ends the waits.
  void stop();

  /// Of the events that are kept for listeners.
  [[nodiscard]] std::size_t bytes() const;

 private:
  /// A message of a topic, or an event without one: of these only the newest matters.
  struct Item {
    std::uint64_t number = 0;  ///< of the event
    std::uint64_t count = 0;   ///< of the events of its key, without old ones
    bool is_message = false;
    bool old = false;  ///< written before the monitor opened the recording
    std::string key;   ///< topic, or type of event
    std::string text;
  };
  using ItemPointer = std::shared_ptr<const Item>;
  using Clock = std::chrono::steady_clock;

  void run();
  void take_status(const std::string& status);
  void take(const io::McapMessage& message, bool old);
  void publish(const std::string& key, std::string text);
  void add(Item item);
  [[nodiscard]] std::vector<ItemPointer> since(const Listener& listener) const;

  const LiveLink& link_;
  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  bool quit_ = false;
  std::uint64_t number_ = 0;
  std::map<std::string, std::uint64_t> counts_;  ///< by key
  std::deque<ItemPointer> kept_;
  std::size_t kept_bytes_ = 0;
  std::map<std::string, ItemPointer> newest_;
  std::optional<RecordingTail> tail_;  ///< of the thread
  std::thread thread_;
};

}  // namespace wayfare::examples
