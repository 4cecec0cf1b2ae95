#pragma once

#include <string>

#include <wayfare/core/result.hpp>
#include <wayfare/io/mcap.hpp>

namespace wayfare::examples {

inline std::string schema_of(const io::McapContents& contents, const io::McapChannel& channel) {
  for (const io::McapSchema& s : contents.schemas)
    if (s.id == channel.schema) return s.name;
  return {};
}

inline const io::McapChannel* find_topic(const io::McapContents& contents,
                                         const std::string& topic) {
  for (const io::McapChannel& c : contents.channels)
    if (c.topic == topic) return &c;
  return nullptr;
}

inline Error no_topic(const std::string& topic) {
  return Error{ErrorCode::not_found, "there is no topic '" + topic + "'"};
}

}  // namespace wayfare::examples
