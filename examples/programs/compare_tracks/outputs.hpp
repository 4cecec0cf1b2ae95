#pragma once

#include <string>

#include <wayfare/core/result.hpp>
#include <wayfare/eval/track_comparison.hpp>
#include <wayfare/io/report.hpp>

#include "support/program_files.hpp"

namespace wayfare::examples {

/// Two tracks compared, and what is said of them.
struct TracksCompared {
  std::string title, first, second;  ///< names of the tracks
  eval::Track reference;             ///< the second track
  eval::TrackComparison comparison;
  bool has_height = true;
  bool aligned = false;
  Facts facts;
};

/// Writes errors.csv, errors.svg, plan.svg and report.html; without a folder only what --json asks
/// for.
[[nodiscard]] Result<void> write_comparison(const OutputArguments& to, const TracksCompared& run);

}  // namespace wayfare::examples
