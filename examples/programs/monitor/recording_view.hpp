#pragma once

// Queries of the monitor's page on a recording, as JSON, CSV or MCAP.

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/io/mcap.hpp>

#include "scan_map.hpp"

namespace wayfare::examples {

/// Receives the pieces of a response; false ends it.
using PieceSink = std::function<bool(std::string_view)>;

/// Times of logging in seconds after the recording's start; both ends are included.
struct Interval {
  static constexpr double kAll = 1e9;
  double from_s = 0.0;
  double until_s = kAll;
};

/// One recording. Thread-safe; a growing file is reread at intervals.
class RecordingView {
 public:
  explicit RecordingView(std::string path) : path_(std::move(path)) {}

  [[nodiscard]] const std::string& path() const { return path_; }
  /// Size, times, topics with their numbers of messages, schemas, and problems of the file.
  [[nodiscard]] Result<std::string> contents() const;
  /// Columns t and numeric fields (such as `angular_velocity.x`, `ranges.17`) of a topic's JSON
  /// messages, at most about `most` rows: of more messages, alternately the minima and maxima of
  /// consecutive groups. Fields that are no number are null, and a row of them stands in each gap
  /// of more than five times what 95 % of the intervals between messages do not exceed.
  [[nodiscard]] Result<std::string> series(const std::string& topic,
                                           const std::vector<std::string>& fields,
                                           const Interval& interval, std::size_t most) const;
  /// The messages of `topics` in order of time, each in two lines, and a line with the time `until`
  /// up to which all are there; it is earlier than that of `interval` where they exceed a limit.
  /// `before`: first the last message of each topic before the interval.
  [[nodiscard]] Result<std::string> range(const std::set<std::string>& topics,
                                          const Interval& interval, bool before) const;
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
  [[nodiscard]] Result<void> csv(const std::string& topic, const Interval& interval,
                                 const PieceSink& sink) const;
  /// The messages of `topics` (empty: all) as a recording; where the interval begins later than the
  /// recording, with the poses of sensors that hold there.
  [[nodiscard]] Result<void> mcap(const std::set<std::string>& topics, const Interval& interval,
                                  const PieceSink& sink) const;

 private:
  using Reader = std::shared_ptr<const io::McapReader>;
  [[nodiscard]] Result<Reader> reader() const;
  /// Longer intervals between a topic's messages are gaps.
  [[nodiscard]] double gap_s(const io::McapReader& file, const io::McapChannel& channel) const;

  struct Gap {
    std::uint64_t messages = 0;  ///< of which it was found
    double s = 0.0;
  };

  std::string path_;
  mutable std::mutex mutex_;
  mutable Reader reader_;
  mutable std::uint64_t size_ = 0;
  mutable std::chrono::steady_clock::time_point reopen_;  ///< not reread before
  mutable std::map<std::string, Gap> gaps_;               ///< by topic
  mutable ScanMap map_;
};

}  // namespace wayfare::examples
