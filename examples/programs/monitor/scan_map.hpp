#pragma once

#include <mutex>
#include <optional>
#include <string>

#include <wayfare/core/result.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/io/mcap.hpp>
#include <wayfare/slam/graph_slam.hpp>

namespace wayfare::examples {

/// The map of a recording's laser scans by graph SLAM without odometry, which grows with it.
/// Thread-safe.
class ScanMap {
 public:
  /// A PNG of map and path, after adding the scans of `topic` that were logged since the last call;
  /// those of the first `most_s` seconds only. Errors: no scans, or none that could be used.
  [[nodiscard]] Result<std::string> png(const io::McapReader& file, const std::string& topic,
                                        double most_s);
  /// Side of the pixels.
  [[nodiscard]] static double cell_m();

 private:
  [[nodiscard]] Result<void> add(const io::McapReader& file, const std::string& topic,
                                 double most_s);

  std::mutex mutex_;
  GraphSlam slam_;
  std::optional<LogTime> first_;  ///< of the scans' times
  LogTime read_;                  ///< time of logging up to which they were read
};

}  // namespace wayfare::examples
