#include "pairs.hpp"

#include <cmath>
#include <map>

#include <wayfare/slam/graph_slam.hpp>

namespace wayfare::examples {
namespace {

/// The first scan after `i` at sufficient distance.
std::size_t partner(const std::vector<SE2d>& poses, std::size_t i, double apart_m) {
  for (std::size_t j = i + 1; j < poses.size(); ++j) {
    const SE2d moved = poses[i].inverse() * poses[j];
    if (moved.translation().norm() >= apart_m || std::abs(moved.heading().degrees()) >= 30)
      return j;
  }
  return poses.size();
}

}  // namespace

Result<std::vector<ScanPair>> pairs_of(const Recording& recording, std::size_t count,
                                       double apart_m,
                                       const std::function<bool(double)>& progress) {
  const auto slam = run_graph_slam(recording, {}, progress);
  if (!slam) return slam.error();
  // A scan that was refused has no pose.
  std::map<LogTime, SE2d> pose_at;
  for (const StampedPose& p : slam->trajectory) pose_at.emplace(p.time, p.T_map_base.raw());
  std::vector<const LaserScan*> scans;
  std::vector<SE2d> poses;
  for (const LaserScan& scan : recording.scans)
    if (const auto at = pose_at.find(scan.time); at != pose_at.end()) {
      scans.push_back(&scan);
      poses.push_back(at->second);
    }
  std::vector<ScanPair> pairs;
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t i = k * poses.size() / count;
    const std::size_t j = partner(poses, i, apart_m);
    if (j < poses.size()) pairs.push_back({scans[i], scans[j], poses[i].inverse() * poses[j]});
  }
  if (pairs.empty())
    return Error{ErrorCode::invalid, "no two scans are " + std::to_string(apart_m) + " m apart"};
  return pairs;
}

}  // namespace wayfare::examples
