#include "localisation/gather_radar.hpp"

#include <algorithm>
#include <cmath>
#include <span>

namespace wayfare {
namespace {

GatheredRadar gather(std::span<const RadarScan> frames, const SE2d& T_base_radar,
                     const OdometryTrack& odometry) {
  GatheredRadar scan{frames.back().time, {}};
  const auto last = odometry.at(scan.time);
  for (const RadarScan& frame : frames) {
    const auto here = odometry.at(frame.time);
    const SE2d T_last_radar =
        last && here ? last->raw().inverse() * here->raw() * T_base_radar : T_base_radar;
    for (const RadarPoint& p : frame.points) {
      const Eigen::Vector2d at = T_last_radar * Eigen::Vector2d(p.x_m, p.y_m);
      if (at.allFinite()) scan.points.push_back(at.cast<float>());
    }
  }
  return scan;
}

}  // namespace

std::vector<GatheredRadar> gather_radar(const Recording& recording, const OdometryTrack& odometry,
                                        const RadarWeighing& options) {
  const std::span<const RadarScan> frames = recording.radar;
  const std::size_t most = std::max<std::size_t>(options.frames, 1);
  std::vector<GatheredRadar> scans;
  for (std::size_t first = 0; first < frames.size();) {
    std::size_t n = 1;
    while (n < most && first + n < frames.size() &&
           to_seconds(frames[first + n].time - frames[first].time) <= options.longest_s)
      ++n;
    scans.push_back(gather(frames.subspan(first, n), recording.T_base_radar.raw(), odometry));
    first += n;
  }
  return scans;
}

}  // namespace wayfare
