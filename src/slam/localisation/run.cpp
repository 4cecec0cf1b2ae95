#include <algorithm>
#include <cmath>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include <wayfare/slam/detail/recorded_localiser.hpp>
#include <wayfare/slam/detail/scans.hpp>
#include <wayfare/slam/localisation.hpp>
#include <wayfare/sync/odometry_track.hpp>

#include "sync/gather_radar.hpp"

namespace wayfare {
namespace {

/// The library's own, which checks its scans itself.
class RecordedByLibrary final : public detail::RecordedLocaliser {
 public:
  RecordedByLibrary(Localiser& localiser, const LocalisationControl& control)
      : localiser_(localiser), control_(control) {}
  void before(std::size_t scan) override {
    if (control_.before_scan) control_.before_scan(scan, localiser_);
  }
  Result<void> add_motion(LogTime time, const Odometry& odometry) override {
    return localiser_.add_motion(time, odometry);
  }
  Result<LocalisationOutcome> add_lidar(const LaserScan& scan, const Odometry& odometry) override {
    return localiser_.add_scan(scan, odometry);
  }
  Result<LocalisationOutcome> add_radar(LogTime time, const PointSet& points_base,
                                        const Odometry& odometry) override {
    return localiser_.add_radar(time, points_base, odometry);
  }
  [[nodiscard]] std::vector<PoseParticle> particles() const override {
    return localiser_.particles();
  }

 private:
  Localiser& localiser_;
  const LocalisationControl& control_;
};

/// A scan of one sensor.
struct SensorScan {
  LogTime time;
  std::size_t index = 0;  // among its sensor's
  const LaserScan* lidar = nullptr;
  const GatheredRadar* radar = nullptr;
};

// Each sensor's scans in their given order, late ones too; LiDAR first at equal times.
std::vector<SensorScan> scans_by_time(std::span<const LaserScan> scans,
                                      std::span<const GatheredRadar> radar) {
  std::vector<SensorScan> scans_in_order;
  scans_in_order.reserve(scans.size() + radar.size());
  std::size_t r = 0;
  const auto take_radar = [&] {
    scans_in_order.push_back({radar[r].time, r, nullptr, &radar[r]});
    ++r;
  };
  for (std::size_t i = 0; i < scans.size(); ++i) {
    while (r < radar.size() && radar[r].time < scans[i].time) take_radar();
    scans_in_order.push_back({scans[i].time, i, &scans[i], nullptr});
  }
  while (r < radar.size()) take_radar();
  return scans_in_order;
}

}  // namespace

Trajectory LocalisationRun::trajectory(bool converged_only) const {
  Trajectory result;
  for (const LocalisationOutcome& o : outcomes)
    if (o.particles > 0 && (o.converged || !converged_only))
      result.push_back({o.time, MapPose(o.T_map_base.mean)});
  return result;
}

Result<LocalisationRun> run_localisation(const Recording& recording,
                                         std::shared_ptr<const LocalisationMap> map,
                                         LocalisationOptions options, std::uint64_t seed,
                                         const std::optional<Gaussian<SE2d>>& start,
                                         const LocalisationControl& control) {
  options.T_base_laser = recording.T_base_laser;
  const detail::RecordedSensors sensors{options.use_lidar,
                                        options.use_radar && map->has(RangeSensor::radar),
                                        options.radar.frames, options.radar.longest_s};
  Localiser localiser(std::move(map), options, seed);
  if (start)
    if (auto ok = localiser.start_at(*start); !ok) return ok.error();
  RecordedByLibrary recorded(localiser, control);
  return detail::run(recorded, recording, sensors, control.progress, control.snapshots_at);
}

Result<LocalisationRun> detail::run(RecordedLocaliser& localiser, const Recording& recording,
                                    const RecordedSensors& sensors,
                                    const std::function<bool(double)>& progress,
                                    std::span<const double> snapshots_at) {
  const OdometryTrack odometry(recording.odometry);
  ScanDeskewer deskewer(recording.T_base_laser);
  const auto add_lidar =
      [&](const LaserScan& scan,
          const std::optional<OdomPose>& odometry_now) -> Result<LocalisationOutcome> {
    const auto instant = deskewer(scan, recording.odometry, recording.gyro);
    return instant ? localiser.add_lidar(**instant, odometry_now) : instant.error();
  };
  std::vector<GatheredRadar> radar;
  if (sensors.radar)
    radar = gather_radar(recording, odometry, {sensors.radar_frames, sensors.radar_longest_s});
  const std::size_t lidar_scans = sensors.lidar ? recording.scans.size() : 0;
  const auto scans_in_order = scans_by_time(std::span(recording.scans).first(lidar_scans), radar);
  const std::size_t n = scans_in_order.size();
  std::vector<std::size_t> snapshots;
  for (const double u : snapshots_at)
    if (!std::isnan(u))
      snapshots.push_back(static_cast<std::size_t>(std::clamp(u, 0.0, 1.0) *
                                                   static_cast<double>(n > 0 ? n - 1 : 0)));
  LocalisationRun run;
  detail::Refusals refused;
  for (std::size_t i = 0; i < n; ++i) {
    const SensorScan& scan = scans_in_order[i];
    localiser.before(i);
    if (!run.outcomes.empty())
      detail::add_odometry_of_gap(localiser, odometry, run.outcomes.back().time, scan.time);
    const auto odometry_now = odometry.at(scan.time);
    auto outcome = scan.radar ? localiser.add_radar(scan.time, scan.radar->points, odometry_now)
                              : add_lidar(*scan.lidar, odometry_now);
    if (!outcome) {
      refused.add(outcome, (scan.radar ? "radar scan " : "scan ") + std::to_string(scan.index));
    } else if (!run.outcomes.empty() && run.outcomes.back().time == outcome->time) {
      run.outcomes.back() = *outcome;
    } else {
      run.outcomes.push_back(*outcome);
    }
    if (std::find(snapshots.begin(), snapshots.end(), i) != snapshots.end())
      run.snapshots.push_back({scan.time, localiser.particles()});
    if (progress && !progress(static_cast<double>(i + 1) / static_cast<double>(n))) break;
  }
  if (run.outcomes.empty())
    return Error{ErrorCode::invalid,
                 n == 0 ? "the recording has no scan of a sensor in use" : refused.first};
  run.refused_scans = refused.count;
  run.first_refusal = std::move(refused.first);
  return run;
}

}  // namespace wayfare
