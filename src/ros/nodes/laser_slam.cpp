#include "ros/nodes/laser_slam.hpp"

#include <cmath>
#include <utility>

namespace wayfare::ros {
namespace {

template <class System>
detail::Owned<LaserSlam> owned(System* system) {
  return {system, [](LaserSlam* object) { delete object; }};
}

class SubmapRunner final : public LaserSlam {
 public:
  explicit SubmapRunner(const SlamNodeOptions& o) : map_(o.map), slam_(o.slam) {}

  void add(const MargSample&) override {}
  Result<ScanOutcome> add_scan(const wayfare::LaserScan& scan, const MotionHint& hint) override {
    return slam_.add_scan(scan, hint);
  }
  Result<void> finish() override { return slam_.finish(); }
  [[nodiscard]] Trajectory trajectory() const override { return slam_.latest_trajectory(); }
  [[nodiscard]] wayfare::OccupancyGrid map() const override { return slam_.latest_part(map_); }
  [[nodiscard]] PieceStatistics pieces() const override { return slam_.statistics(); }
  [[nodiscard]] Eigen::Matrix3d covariance() const override { return slam_.covariance(); }
  [[nodiscard]] SE2d T_odom_base() const override { return slam_.local().T_local_base.raw(); }

 private:
  OccupancyGridOptions map_;
  SubmapSlam slam_;
};

class WalkerRunner final : public LaserSlam {
 public:
  WalkerRunner(const SlamNodeOptions& o, const PedestrianSlamOptions& walker)
      : map_(o.map), slam_(walker) {}

  void add(const MargSample& sample) override { slam_.add(sample); }
  Result<ScanOutcome> add_scan(const wayfare::LaserScan& scan, const MotionHint&) override {
    return slam_.add_scan(scan);
  }
  Result<void> finish() override { return slam_.finish(); }
  [[nodiscard]] Trajectory trajectory() const override { return slam_.slam().latest_trajectory(); }
  [[nodiscard]] wayfare::OccupancyGrid map() const override {
    return slam_.slam().latest_part(map_);
  }
  [[nodiscard]] PieceStatistics pieces() const override { return slam_.slam().statistics(); }
  [[nodiscard]] Eigen::Matrix3d covariance() const override { return slam_.slam().covariance(); }
  [[nodiscard]] SE2d T_odom_base() const override {
    return slam_.slam().local().T_local_base.raw();
  }

 private:
  OccupancyGridOptions map_;
  PedestrianSlam slam_;
};

/// One map, to which all scans are matched: nothing jumps.
class HectorRunner final : public LaserSlam {
 public:
  explicit HectorRunner(const HectorSlamOptions& options) : slam_(options) {}

  void add(const MargSample& s) override {
    slam_.add(ImuSample{s.time, s.angular_rate_radps, s.specific_force_mps2});
  }
  Result<ScanOutcome> add_scan(const wayfare::LaserScan& scan, const MotionHint& hint) override {
    return slam_.add_scan(scan, hint.odometry);
  }
  Result<void> finish() override { return {}; }
  [[nodiscard]] Trajectory trajectory() const override { return slam_.trajectory(); }
  [[nodiscard]] wayfare::OccupancyGrid map() const override { return slam_.map(); }
  [[nodiscard]] Eigen::Matrix3d covariance() const override { return slam_.covariance(); }
  [[nodiscard]] SE2d T_odom_base() const override {
    const Trajectory& poses = slam_.trajectory();
    return poses.empty() ? SE2d() : poses.back().T_map_base.raw();
  }

 private:
  HectorSlam slam_;
};

SO3d about_z(double radians) { return SO3d::exp(Eigen::Vector3d(0, 0, radians)); }

}  // namespace

detail::Owned<LaserSlam> make_laser_slam(const SlamNodeOptions& options,
                                         const Transform2<frame::Base, frame::Laser>& T_base_laser,
                                         const std::optional<SO3d>& q_base_unit) {
  const SO3d q_base_laser = about_z(T_base_laser.raw().heading().radians());
  const auto& forward = options.unit_forward;
  const SO3d q_unit_laser = forward       ? about_z(std::atan2(forward->y(), forward->x()))
                            : q_base_unit ? q_base_unit->inverse() * q_base_laser
                                          : SO3d();
  SlamNodeOptions o = options;
  o.slam.T_base_laser = T_base_laser;
  if (o.system == LaserSystem::submap) return owned(new SubmapRunner(o));
  if (o.system == LaserSystem::hector) {
    o.hector.T_base_laser = T_base_laser;
    o.hector.q_base_unit =
        forward ? q_base_laser * q_unit_laser.inverse() : q_base_unit.value_or(SO3d());
    return owned(new HectorRunner(o.hector));
  }
  o.walker.slam = o.slam;
  o.walker.q_unit_laser = q_unit_laser;
  o.walker.pedestrian.forward = forward ? *forward : q_unit_laser * Eigen::Vector3d::UnitX();
  return owned(new WalkerRunner(o, o.walker));
}

}  // namespace wayfare::ros
