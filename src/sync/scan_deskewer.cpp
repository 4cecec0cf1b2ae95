#include <wayfare/sync/scan_deskewer.hpp>

#include <algorithm>

namespace wayfare {
namespace {

constexpr double kLongestGap_s = 0.5;

/// The turn from one time to another, later or earlier.
std::optional<double> turned(std::span<const GyroSample> gyro, LogTime from, LogTime to) {
  const GyroTurn turn(gyro);
  const auto by = to < from ? turn.between(to, from) : turn.between(from, to);
  if (!by) return std::nullopt;
  return to < from ? -by->radians() : by->radians();
}

}  // namespace

std::optional<SE2d> OdometryMotion::base_at(LogTime time) const {
  const auto after =
      std::lower_bound(samples_.begin(), samples_.end(), time,
                       [](const OdometrySample& s, LogTime t) { return s.time < t; });
  if (after == samples_.end()) return std::nullopt;
  if (after->time == time) return after->T_odom_base.raw();
  if (after == samples_.begin()) return std::nullopt;
  const OdometrySample& before = *(after - 1);
  const double gap_s = to_seconds(after->time - before.time);
  const double since_s = to_seconds(time - before.time);
  if (!(gap_s < kLongestGap_s) || !(since_s >= 0.0)) return std::nullopt;
  return interpolate(before.T_odom_base.raw(), after->T_odom_base.raw(), since_s / gap_s);
}

std::optional<SE2d> OdometryMotion::operator()(LogTime time) const {
  const auto base = base_at(time);
  if (!base) return std::nullopt;
  if (gyro_.empty()) return *base * T_base_laser_;
  const auto then = base_at(at_);
  const auto turn = turned(gyro_, at_, time);
  if (!then || !turn) return std::nullopt;
  const SO2d heading = then->rotation() * SO2d(Angle::radians(*turn));
  return SE2d(base->translation(), heading) * T_base_laser_;
}

std::optional<SE2d> VelocityMotion::operator()(LogTime time) const {
  Eigen::Vector3d twist = to_seconds(time - at_) * velocity_;
  if (!gyro_.empty()) {
    const auto turn = turned(gyro_, at_, time);
    if (!turn) return std::nullopt;
    twist[2] = *turn;
  }
  return SE2d::exp(twist) * T_base_laser_;
}

Result<const LaserScan*> ScanDeskewer::operator()(const LaserScan& scan,
                                                  std::span<const OdometrySample> odometry,
                                                  std::span<const GyroSample> gyro) {
  if (!scan.is_sweep()) return &scan;
  if (auto ok = detail::check_sweep(scan); !ok) return ok.error();
  if (!gyro.empty() &&
      deskew(scan, OdometryMotion(odometry, T_base_laser_, scan.time, gyro), scan.time, instant_))
    return &instant_;
  if (deskew(scan, OdometryMotion(odometry, T_base_laser_), scan.time, instant_)) return &instant_;
  const Eigen::Vector3d velocity = velocity_.value_or(Eigen::Vector3d::Zero());
  if (!gyro.empty() &&
      deskew(scan, VelocityMotion(scan.time, velocity, T_base_laser_, gyro), scan.time, instant_))
    return &instant_;
  if (!velocity_) return &scan;
  if (auto ok =
          deskew(scan, VelocityMotion(scan.time, velocity, T_base_laser_), scan.time, instant_);
      !ok)
    return ok.error();
  return &instant_;
}

/// Over less than a millisecond or more than a second no velocity is measured.
void ScanDeskewer::placed(LogTime time, const SE2d& T_map_base, bool moved) {
  constexpr double kShortest_s = 1e-3, kLongest_s = 1.0;
  if (last_ && !moved) {
    const double dt = to_seconds(time - last_->time);
    if (dt > kShortest_s) {
      velocity_.reset();
      if (dt < kLongest_s) velocity_ = T_map_base.minus(last_->T_map_base) / dt;
    }
  }
  last_ = Placed{time, T_map_base};
}

}  // namespace wayfare
