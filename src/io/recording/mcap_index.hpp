#pragma once

// What a recording holds, and where its messages are: from its summary, or, where none holds
// together, from all of its data.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <wayfare/io/mcap.hpp>

#include "io/recording/mcap_messages.hpp"

namespace wayfare::io::mcap {

/// A chunk, or a message outside of chunks.
struct Place {
  std::uint64_t at = 0;
  LogTime first, last;
  std::uint64_t until = 0;  ///< end of the chunk and of the message indexes behind it; by a summary
};

struct Index {
  McapContents contents;
  Description known;
  std::vector<Place> places;  ///< in order of their first time
};

/// The content of the record at `at`, where there is one of that kind; `buffer` may hold it.
[[nodiscard]] std::optional<std::string_view> content_at(const Source& source, std::uint64_t at,
                                                         Opcode opcode,
                                                         const McapReadOptions& options,
                                                         std::string& buffer);

/// What was wrong is in the contents' problems.
[[nodiscard]] Index make_index(const Source& source, const std::string& name,
                               const McapReadOptions& options);

}  // namespace wayfare::io::mcap
