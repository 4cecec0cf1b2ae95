#pragma once

// What an MCAP recording is made of. MCAP is a container for time-stamped messages of any encoding;
// the format is published at mcap.dev (version 0, magic "\x89MCAP0\r\n").

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include <wayfare/core/time.hpp>

namespace wayfare::io {

using McapMetadata = std::map<std::string, std::string>;

/// What the bytes of a message mean; identifiers count from 1, 0 is "no schema".
struct McapSchema {
  std::uint16_t id = 0;
  std::string name = {};      ///< such as foxglove.LaserScan
  std::string encoding = {};  ///< such as jsonschema
  std::string data = {};
};

/// A stream of messages of one kind.
struct McapChannel {
  std::uint16_t id = 0;
  std::uint16_t schema = 0;
  std::string topic = {};
  std::string message_encoding = {};  ///< such as json
  McapMetadata metadata = {};
};

/// One message as a reader delivers it; `channel` and `data` are gone when the callable returns.
struct McapMessage {
  const McapChannel* channel = nullptr;
  std::uint32_t sequence = 0;
  LogTime log_time;      ///< when it was received
  LogTime publish_time;  ///< when it was made or measured
  std::string_view data;
};

/// How much a file holds.
struct McapStatistics {
  std::uint64_t messages = 0;
  std::uint32_t chunks = 0;
  LogTime first, last;  ///< log times of the earliest and the latest message
  std::map<std::uint16_t, std::uint64_t> messages_of;  ///< by channel
};

}  // namespace wayfare::io
