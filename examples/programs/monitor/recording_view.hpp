#pragma once

// Queries of the monitor's page on a recording, as JSON, CSV or MCAP.

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include <wayfare/core/result.hpp>
#include <wayfare/io/mcap.hpp>

#include "scan_map.hpp"

namespace wayfare::examples {

/// Receives the pieces of a response; false ends it.
using PieceSink = std::function<bool(std::string_view)>;

/// One recording. Thread-safe; a growing file is reread at intervals.
class RecordingView {
 public:
  explicit RecordingView(std::string path) : path_(std::move(path)) {}

  [[nodiscard]] const std::string& path() const { return path_; }
  /// Size, times, topics with their numbers of messages, and problems of the file.
  [[nodiscard]] Result<std::string> contents() const;
  /// Columns t, specific force and angular rate of an inertial unit, at most about `most` rows: of
  /// more samples, alternately the minima and maxima of consecutive groups.
  [[nodiscard]] Result<std::string> inertial(const std::string& topic, std::size_t most) const;
  /// The last message of `topic` before `t_s` after the recording's start.
  [[nodiscard]] Result<std::string> message(const std::string& topic, double t_s) const;
  /// Path of a walker with the unit: columns t, x, y, heading.
  [[nodiscard]] Result<std::string> walk(const std::string& topic) const;
  /// A PNG of map and path from the laser scans of at most `most_s` seconds, by graph SLAM without
  /// odometry. Of a growing recording each call adds the scans since the last.
  [[nodiscard]] Result<std::string> map_png(double most_s) const;
  /// Side of the map's pixels.
  [[nodiscard]] static double map_cell_m();

  /// One line per message, beam of a scan or point of a point cloud.
  [[nodiscard]] Result<void> csv(const std::string& topic, const PieceSink& sink) const;
  /// The messages of `topics` (empty: all) as a recording.
  [[nodiscard]] Result<void> mcap(const std::set<std::string>& topics, const PieceSink& sink) const;

 private:
  using Reader = std::shared_ptr<const io::McapReader>;
  [[nodiscard]] Result<Reader> reader() const;

  std::string path_;
  mutable std::mutex mutex_;
  mutable Reader reader_;
  mutable std::uint64_t size_ = 0;
  mutable std::chrono::steady_clock::time_point reopen_;  ///< not reread before
  mutable ScanMap map_;
};

}  // namespace wayfare::examples
