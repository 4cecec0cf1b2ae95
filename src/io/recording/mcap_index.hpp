#pragma once

// The contents of a recording and the positions of its messages: from its summary, or from all its
// data where that is missing or inconsistent.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <wayfare/io/mcap.hpp>

#include "io/recording/mcap_messages.hpp"

namespace wayfare::io::mcap {

/// A chunk, or a message outside of chunks.
struct IndexEntry {
  std::uint64_t at = 0;
  LogTime first, last;
  std::uint64_t until = 0;  ///< end of the chunk and of the message indexes behind it; by a summary
};

struct Index {
  McapContents contents;
  Description known;
  std::vector<IndexEntry> entries;  ///< in order of their first time
};

/// The content of the record of type `opcode` at `at`, if there is one. May use `buffer`.
[[nodiscard]] std::optional<std::string_view> content_at(const Source& source, std::uint64_t at,
                                                         Opcode opcode,
                                                         const McapReadOptions& options,
                                                         std::string& buffer);

/// Faults are reported in the contents' problems.
[[nodiscard]] Index make_index(const Source& source, const std::string& name,
                               const McapReadOptions& options);

}  // namespace wayfare::io::mcap
