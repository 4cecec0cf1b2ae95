#include "live_feed.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "message_text.hpp"

namespace wayfare::examples {
namespace {

using nlohmann::json;
using std::chrono::milliseconds;

constexpr std::size_t kKept = std::size_t{8} << 20;      // for all listeners
constexpr std::size_t kAtOnce = std::size_t{256} << 10;  // to one listener, later
constexpr std::size_t kAtBegin = std::size_t{1} << 20;   // to a new listener
constexpr std::size_t kLargest = std::size_t{1} << 20;   // message

std::string event(const std::string& type, const std::string& data) {
  return (type.empty() ? "" : "event: " + type + '\n') + "data: " + data + "\n\n";
}

}  // namespace

void LiveFeed::stop() {
  {
    const std::lock_guard lock(mutex_);
    quit_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

std::size_t LiveFeed::bytes() const {
  const std::lock_guard lock(mutex_);
  return kept_bytes_;
}

void LiveFeed::publish(const std::string& key, std::string text) {
  add({0, 0, false, false, key, std::move(text)});
}

void LiveFeed::take(const io::McapMessage& message, bool old) {
  if (message.channel->message_encoding != "json") return;
  add({0, 0, true, old, message.channel->topic, message_lines(message, "data: ")});
}

void LiveFeed::add(Item given) {
  const std::lock_guard lock(mutex_);
  given.count = counts_[given.key] += given.old ? 0 : 1;
  if (given.text.size() > kLargest) return;  // counted as missed
  given.number = ++number_;
  const auto item = std::make_shared<const Item>(std::move(given));
  newest_[item->key] = item;
  if (item->old) {
    // Of older messages all listeners get the newest only.
    kept_.clear();
    kept_bytes_ = 0;
    return;
  }
  kept_bytes_ += item->text.size();
  kept_.push_back(item);
  while (kept_bytes_ > kKept) {
    kept_bytes_ -= kept_.front()->text.size();
    kept_.pop_front();
  }
}

void LiveFeed::take_status(const std::string& text) {
  publish("status", event("", text));
  const json status = json::parse(text, nullptr, false);
  if (!status.is_object()) return;
  const auto word = [&](const char* key) {
    return status.contains(key) && status[key].is_string() ? status[key].get<std::string>() : "";
  };
  const std::string state = word("state"), file = word("file");
  const bool recording = state == "recording" || state == "stopping";
  if (!recording || file.empty() || (tail_ && tail_->path() == file)) return;
  tail_.emplace(file);
  const std::lock_guard lock(mutex_);
  std::erase_if(newest_, [](const auto& entry) { return entry.second->is_message; });
}

void LiveFeed::run() {
  constexpr milliseconds kPoll(20);
  constexpr std::chrono::seconds kSilence(1);
  std::uint64_t seen = 0, described = 0;
  Clock::time_point heard = Clock::now(), described_at = heard - kSilence;
  for (bool more = false;;) {
    {
      const std::lock_guard lock(mutex_);
      if (quit_) return;
    }
    const std::string status = link_.wait(seen, more ? milliseconds(0) : kPoll);
    const auto now = Clock::now();
    if (!status.empty()) {
      heard = now;
      take_status(status);
    } else if (now - heard >= kSilence) {
      heard = now;
      publish("problem", event("problem", text_of(link_.problem())));
    }
    if (tail_) {
      more = tail_->poll([&](const auto& m, bool old) { take(m, old); });
      const std::uint64_t bytes = tail_->contents().bytes;
      if (bytes != described && now - described_at >= kSilence) {
        described = bytes;
        described_at = now;
        publish("contents", event("contents", contents_text(tail_->path(), tail_->contents())));
      }
    }
    changed_.notify_all();
  }
}

std::vector<LiveFeed::ItemPointer> LiveFeed::since(const Listener& listener) const {
  const bool begins = listener.seen == 0;
  std::vector<ItemPointer> found;
  const auto add = [&](const ItemPointer& item) {
    const bool wanted = item->number > listener.seen &&
                        (item->is_message ? listener.topics.contains(item->key)
                                          : !begins || newest_.at(item->key) == item);
    if (wanted) found.push_back(item);
    return wanted ? item->text.size() : 0;
  };
  std::size_t bytes = 0;
  const std::size_t most = begins ? kAtBegin : kAtOnce;
  auto it = kept_.rbegin();
  for (; it != kept_.rend() && (*it)->number > listener.seen && bytes <= most; ++it)
    bytes += add(*it);
  const bool all = !kept_.empty() && kept_.front()->number <= listener.seen + 1 && bytes <= most;
  if (!all) {
    if (!begins) found.clear();
    for (const auto& [key, item] : newest_)
      if (std::ranges::find(found, item) == found.end()) add(item);
  }
  std::ranges::sort(found, {}, &Item::number);
  return found;
}

std::string LiveFeed::wait(Listener& listener, milliseconds timeout) const {
  std::vector<ItemPointer> items;
  {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, timeout, [&] {
      if (quit_) return true;
      items = since(listener);
      return !items.empty();
    });
    if (quit_ || items.empty()) return {};
    listener.seen = std::max(number_, listener.seen);
  }
  std::string out;
  bool open = false, missed = false;  // open: in an event of several messages
  for (const ItemPointer& item : items) {
    if (item->is_message != open)
      out += std::exchange(open, item->is_message) ? "\n" : "event: messages\n";
    out += item->text;
    if (!item->is_message) continue;
    std::uint64_t& count = listener.count.try_emplace(item->key, item->count - 1).first->second;
    if (item->count > count + 1) {
      listener.missed[item->key] += item->count - count - 1;
      missed = true;
    }
    count = item->count;
  }
  if (open) out += '\n';
  if (missed) out += event("missed", text_of(json(listener.missed)));
  return out;
}

}  // namespace wayfare::examples
