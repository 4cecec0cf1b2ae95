#pragma once

// Exports of a recording.

#include <functional>
#include <set>
#include <string>
#include <string_view>

#include <wayfare/core/result.hpp>
#include <wayfare/io/mcap.hpp>

namespace wayfare::examples {

/// Receives the pieces of a response; false ends it.
using PieceSink = std::function<bool(std::string_view)>;

/// One line per message, beam of a scan or point of a point cloud.
[[nodiscard]] Result<void> export_csv(const io::McapReader& file, const std::string& topic,
                                      const PieceSink& sink);
/// The messages of `topics` (empty: all) as a recording.
[[nodiscard]] Result<void> export_mcap(const io::McapReader& file,
                                       const std::set<std::string>& topics, const PieceSink& sink);

}  // namespace wayfare::examples
