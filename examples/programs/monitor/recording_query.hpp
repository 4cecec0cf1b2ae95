#pragma once

// Topics and intervals of recordings.

#include <functional>
#include <set>
#include <string>

#include <wayfare/core/result.hpp>
#include <wayfare/io/mcap.hpp>

#include "recording_view.hpp"

namespace wayfare::examples {

/// Null if there is none.
[[nodiscard]] inline const io::McapChannel* find_topic(const io::McapContents& contents,
                                                       const std::string& topic) {
  for (const io::McapChannel& c : contents.channels)
    if (c.topic == topic) return &c;
  return nullptr;
}

[[nodiscard]] inline Error no_topic(const std::string& topic) {
  return Error{ErrorCode::not_found, "there is no topic '" + topic + "'"};
}

/// The messages of an interval, in the order of the file.
[[nodiscard]] inline io::McapQuery query_of(const io::McapContents& contents,
                                            std::set<std::string> topics,
                                            const Interval& interval) {
  const LogTime start = contents.statistics.first;
  io::McapQuery query{io::McapOrder::file, std::move(topics)};
  if (interval.from_s > 0.0) query.from = start + from_seconds(interval.from_s);
  if (interval.until_s < Interval::kAll) query.until = start + from_seconds(interval.until_s);
  return query;
}

/// Passes on the last message of a topic up to `until`, if there is one.
inline void read_last(const io::McapReader& file, const std::string& topic, LogTime until,
                      const std::function<void(const io::McapMessage&)>& sink) {
  const io::McapContents& c = file.contents();
  // Searched in growing intervals.
  for (double back_s = 1.0; back_s < 1e6; back_s *= 16.0) {
    const LogTime from = until - from_seconds(back_s);
    LogTime last = from;
    bool found = false;
    file.read({io::McapOrder::log_time, {topic}, from, until}, [&](const io::McapMessage& m) {
      found = true;
      last = m.log_time;
      return true;
    });
    if (found) {
      file.read({io::McapOrder::log_time, {topic}, last, until}, [&](const io::McapMessage& m) {
        sink(m);
        return false;
      });
      return;
    }
    if (from < c.statistics.first) return;
  }
}

}  // namespace wayfare::examples
