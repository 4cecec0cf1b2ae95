#include <wayfare/slam/radar_slam.hpp>

#include <wayfare/core/contract.hpp>
#include <wayfare/match/correlative.hpp>

#include "slam/radar_slam/engine.hpp"

namespace wayfare {

RadarSlam::RadarSlam(const RadarSlamOptions& options) : RadarSlam(CorrelativeMatcher(), options) {}
RadarSlam::RadarSlam(const detail::MakeParticleMatcher& make, const RadarSlamOptions& options)
    : engine_(detail::make_owned<Engine>(make, options)) {}

Result<void> RadarSlam::move(const Gaussian<SE2d>& increment, double gyro_s) {
  return engine_->move({increment, gyro_s});
}
Result<RbpfOutcome> RadarSlam::add_lidar(const LaserScan& scan) { return engine_->add_lidar(scan); }
Result<RbpfOutcome> RadarSlam::add_radar(LogTime time, const PointSet& points_base) {
  return engine_->add_radar(time, points_base);
}
Trajectory RadarSlam::trajectory() const { return engine_->trajectory(); }
Trajectory RadarSlam::trajectory(std::size_t particle) const {
  WAYFARE_EXPECTS(particle < particles().size(), "there is no such particle");
  return engine_->filter().trajectory(particle);
}
std::optional<StampedPose> RadarSlam::pose() const { return engine_->filter().pose(); }
Trajectory RadarSlam::latest_trajectory() const { return engine_->filter().trajectory(); }
Eigen::Matrix3d RadarSlam::covariance() const { return engine_->filter().covariance(); }
const OccupancyGrid& RadarSlam::lidar_map() const { return engine_->filter().maps().lidar; }
const OccupancyGrid& RadarSlam::radar_map() const { return engine_->filter().maps().radar; }
RbpfMaps RadarSlam::all_maps() const { return engine_->maps(); }
WallCrossings RadarSlam::wall_crossings() const { return engine_->wall_crossings(); }
void RadarSlam::finish() { engine_->join_all(); }
std::span<const RbpfParticle<RbpfMaps>> RadarSlam::particles() const {
  if (engine_->filter().filter() == nullptr) return {};
  return engine_->filter().filter()->particles();
}
std::span<const double> RadarSlam::log_weights() const {
  if (engine_->filter().filter() == nullptr) return {};
  return engine_->filter().filter()->log_weights();
}
const RbpfStatistics& RadarSlam::statistics() const { return engine_->statistics(); }

}  // namespace wayfare
