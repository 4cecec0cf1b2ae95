#include <memory>
#include <utility>

#include <wayfare/slam/basic_localiser.hpp>
#include <wayfare/slam/detail/recorded_localiser.hpp>
#include <wayfare/slam/detail/scans.hpp>
#include <wayfare/slam/localisation.hpp>

#include "slam/localisation/scan_weigher.hpp"

namespace wayfare {

Result<void> detail::check_lidar(const LaserScan& scan, const std::optional<LogTime>& last) {
  if (!has_finite_bearings(scan))
    return Error{ErrorCode::invalid, "a scan whose bearings are not finite"};
  if (last && scan.time <= *last)
    return Error{ErrorCode::invalid, "a scan not later than the last: late or duplicated"};
  return {};
}

Result<void> detail::check_radar(LogTime time, const PointSet& points_base,
                                 const std::optional<LogTime>& last) {
  if (last && time < *last)
    return Error{ErrorCode::invalid, "a radar scan earlier than the last scan"};
  for (std::size_t i = 0; i < points_base.size(); ++i)
    if (!points_base[i].allFinite())
      return Error{ErrorCode::invalid, "a radar scan whose points are not finite"};
  return {};
}

class Localiser::Engine : public BasicLocaliser<LocalisationMap, ScanModels> {
 public:
  Engine(std::shared_ptr<const LocalisationMap> map, const LocalisationOptions& options,
         std::uint64_t seed)
      : BasicLocaliser(std::move(map),
                       ScanModels(std::make_shared<const LocalisationOptions>(options)), options,
                       options, seed) {}

  template <class Scan>
  Result<LocalisationOutcome> add(LogTime time, const Scan& scan,
                                  const std::optional<OdomPose>& odometry, RangeSensor sensor) {
    auto outcome = add_scan(time, scan, odometry);
    if (!outcome) return outcome.error();
    return LocalisationOutcome{*std::move(outcome), sensor};
  }
};

Localiser::Localiser(std::shared_ptr<const LocalisationMap> map, const LocalisationOptions& options,
                     std::uint64_t seed)
    : engine_(detail::make_owned<Engine>(std::move(map), options, seed)) {}

Result<void> Localiser::start_at(const Gaussian<SE2d>& T_map_base) {
  return engine_->start_at(T_map_base);
}
void Localiser::start_anywhere() { engine_->start_anywhere(); }

Result<void> Localiser::add_motion(LogTime time, const std::optional<OdomPose>& odometry) {
  return engine_->add_motion(time, odometry);
}

Result<LocalisationOutcome> Localiser::add_scan(const LaserScan& scan,
                                                const std::optional<OdomPose>& odometry) {
  if (auto ok = detail::check_lidar(scan, engine_->time()); !ok) return ok.error();
  return engine_->add(scan.time, scan, odometry, RangeSensor::lidar);
}

Result<LocalisationOutcome> Localiser::add_radar(LogTime time, const PointSet& points_base,
                                                 const std::optional<OdomPose>& odometry) {
  if (!engine_->map().has(RangeSensor::radar))
    return Error{ErrorCode::invalid, "the map has no radar detections"};
  if (auto ok = detail::check_radar(time, points_base, engine_->time()); !ok) return ok.error();
  return engine_->add(time, points_base, odometry, RangeSensor::radar);
}

std::vector<PoseParticle> Localiser::particles() const {
  return detail::weighted_poses(engine_->particles());
}

}  // namespace wayfare
