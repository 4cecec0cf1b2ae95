#pragma once

// What the monitor's page asks of a recording, as JSON, CSV or MCAP.

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <utility>

#include <wayfare/core/result.hpp>
#include <wayfare/io/mcap.hpp>

#include "exports.hpp"

namespace wayfare::examples {

/// One recording. Asked from several threads; a file that grows is looked at anew now and then.
class RecordingView {
 public:
  explicit RecordingView(std::string path) : path_(std::move(path)) {}

  [[nodiscard]] const std::string& path() const { return path_; }
  /// Size, times, topics with their numbers of messages, and what is wrong with the file.
  [[nodiscard]] Result<std::string> contents() const;
  /// Columns t and acceleration and rate of an inertial unit, at most about `most` rows: where
  /// there are more samples, in turn the least and the greatest values of each stretch of them.
  [[nodiscard]] Result<std::string> inertial(const std::string& topic, std::size_t most) const;
  /// The message of `topic` that was logged last at `t_s` after the recording's start.
  [[nodiscard]] Result<std::string> message(const std::string& topic, double t_s) const;
  /// Where a walker who carried the unit went: columns t, x, y, heading.
  [[nodiscard]] Result<std::string> walk(const std::string& topic) const;
  /// A map of the laser scans of at most `most_s` seconds as a PNG, by graph SLAM without odometry,
  /// and the pose at each scan.
  [[nodiscard]] Result<std::string> map_png(double most_s) const;
  /// Side of the map's pixels.
  [[nodiscard]] static double map_cell_m();

  [[nodiscard]] Result<void> csv(const std::string& topic, const PieceSink& sink) const;
  [[nodiscard]] Result<void> mcap(const std::set<std::string>& topics, const PieceSink& sink) const;

 private:
  using Reader = std::shared_ptr<const io::McapReader>;
  [[nodiscard]] Result<Reader> reader() const;

  std::string path_;
  mutable std::mutex mutex_;
  mutable Reader reader_;
  mutable std::uint64_t size_ = 0;
  mutable std::chrono::steady_clock::time_point reopen_;  ///< not read through again before
};

}  // namespace wayfare::examples
