#pragma once

// The beginning of a recorded drive, thinned to one scan every 0.2 m or 10°, the default of MRPT's
// filter.

#include <cmath>
#include <cstddef>
#include <ctime>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <wayfare/core/se2.hpp>
#include <wayfare/io/carmen.hpp>
#include <wayfare/sensors/scans.hpp>
#include <wayfare/sync/odometry_track.hpp>

namespace wayfare {

/// Of this process; on a busy machine less variable than wall time.
inline double cpu_seconds() {
  return static_cast<double>(std::clock()) / static_cast<double>(CLOCKS_PER_SEC);
}

struct Drive {
  std::vector<LaserScan> scans;
  std::vector<SE2d> increments;  ///< by odometry, to each scan from the one before
  SE2d T_base_laser;
};

/// Empty without the recording.
inline Drive read_drive(const std::string& name, std::size_t scans) {
  Drive drive;
  const auto log = io::read_carmen(std::string(WAYFARE_DATA_DIR) + "/slam2d/" + name + ".clf.gz");
  if (!log) return drive;
  drive.T_base_laser = log->recording.T_base_laser.raw();
  const OdometryTrack track(log->recording.odometry);
  std::optional<SE2d> last;
  for (const LaserScan& scan : log->recording.scans) {
    const auto pose = track.at(scan.time);
    if (!pose) continue;
    const SE2d since = last ? last->inverse() * pose->raw() : SE2d();
    if (last && since.translation().norm() < 0.2 && std::abs(since.heading().degrees()) < 10)
      continue;
    if (last && scan.time <= drive.scans.back().time) continue;
    last = pose->raw();
    drive.scans.push_back(scan);
    drive.increments.push_back(since);
    if (drive.scans.size() == scans) break;
  }
  return drive;
}

inline const Drive& drive_of(const std::string& name) {
  static std::map<std::string, Drive> drives;
  const auto found = drives.find(name);
  if (found != drives.end()) return found->second;
  return drives[name] = read_drive(name, 150);
}

}  // namespace wayfare
