#pragma once

// What may be taken away of a recording.

#include <functional>
#include <set>
#include <string>
#include <string_view>

#include <wayfare/core/result.hpp>
#include <wayfare/io/mcap.hpp>

namespace wayfare::examples {

/// Takes pieces of a long answer; false ends it.
using PieceSink = std::function<bool(std::string_view)>;

/// A line a message; of scans and point clouds a line a beam or point.
[[nodiscard]] Result<void> export_csv(const io::McapReader& file, const std::string& topic,
                                      const PieceSink& sink);
/// The messages of `topics` (empty: all), as a recording of their own.
[[nodiscard]] Result<void> export_mcap(const io::McapReader& file,
                                       const std::set<std::string>& topics, const PieceSink& sink);

}  // namespace wayfare::examples
