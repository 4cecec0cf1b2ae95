#pragma once

#include <functional>
#include <string>

#include <wayfare/io/mcap.hpp>

namespace wayfare::examples {

/// Lines of comma-separated values of a topic's messages.
struct CsvFormat {
  std::string head;  ///< names of the columns
  std::function<void(std::string& out, const io::McapMessage& message)> lines;
};

/// By the schema of the messages: a line for each sample, beam or point; of other JSON messages one
/// with a column for each field of the schema; of others their time, length and bytes.
[[nodiscard]] CsvFormat csv_format(const io::McapContents& contents,
                                   const io::McapChannel& channel);

}  // namespace wayfare::examples
