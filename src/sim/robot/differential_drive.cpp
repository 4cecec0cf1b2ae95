#include <wayfare/sim/differential_drive.hpp>

#include <algorithm>
#include <cmath>
#include <string>

#include <wayfare/sensors/trajectory.hpp>

namespace wayfare::sim {
namespace {

double approach(double value, double target, double max_change) {
  return value + std::clamp(target - value, -max_change, max_change);
}

// Steers to the waypoint, slowing down for the next corner.
class Driver {
 public:
  Driver(std::span<const Eigen::Vector2d> route, const DriveParams& params)
      : route_(route), params_(params), dt_s_(to_seconds(params.step)) {}

  [[nodiscard]] bool arrived(const SE2d& pose) {
    while (target_ < route_.size() && reached(pose)) ++target_;
    return target_ == route_.size();
  }
  [[nodiscard]] std::size_t target() const { return target_; }

  SE2d advance(const SE2d& pose) {
    const Eigen::Vector2d to_target = pose.inverse() * route_[target_];
    const double off_course = std::atan2(to_target.y(), to_target.x());
    const double turn = std::clamp(params_.heading_gain_per_s * off_course,
                                   -params_.max_turn_rate_rad_s, params_.max_turn_rate_rad_s);
    turn_rate_ = approach(turn_rate_, turn, params_.max_turn_acceleration_rad_s2 * dt_s_);
    speed_ = approach(speed_, wanted_speed(to_target.norm(), off_course),
                      params_.max_acceleration_m_s2 * dt_s_);
    return pose.plus({speed_ * dt_s_, 0.0, turn_rate_ * dt_s_});
  }

 private:
  [[nodiscard]] bool reached(const SE2d& pose) const {
    return (route_[target_] - pose.translation()).norm() <= params_.waypoint_radius_m;
  }

  [[nodiscard]] double wanted_speed(double distance, double off_course) const {
    const double facing = std::max(0.0, std::cos(off_course));
    const double ahead = std::max(0.0, distance - params_.waypoint_radius_m);
    const double at_waypoint = speed_through(target_);
    const double braking =
        std::sqrt(at_waypoint * at_waypoint + 2.0 * params_.max_acceleration_m_s2 * ahead);
    return std::min(params_.max_speed_m_s * facing * facing, braking);
  }

  // Full speed straight ahead, walking pace where the route reverses or ends.
  [[nodiscard]] double speed_through(std::size_t i) const {
    const double slowest = 0.1 * params_.max_speed_m_s;
    if (i + 1 >= route_.size()) return slowest;
    const Eigen::Vector2d in = route_[i] - route_[i - 1], out = route_[i + 1] - route_[i];
    const double cosine = in.dot(out) / std::max(1e-9, in.norm() * out.norm());
    return std::max(slowest, params_.max_speed_m_s * std::max(0.0, cosine));
  }

  std::span<const Eigen::Vector2d> route_;
  const DriveParams& params_;
  double dt_s_;
  std::size_t target_ = 1;
  double speed_ = 0.0;
  double turn_rate_ = 0.0;
};

Carpet floor_at(std::span<const Carpet> carpets, const Eigen::Vector2d& place) {
  for (const Carpet& carpet : carpets)
    if (carpet.covers(place)) return carpet;
  return {.slip_factor = 1.0, .reported_scale = 1.0};
}

// Calls visit(pose, forward, turn) at the end of every `period`: distance rolled, m, and heading
// change, rad, since the previous call.
template <class Visit>
void for_each_period(const Trajectory& truth, Duration period, const Visit& visit) {
  WAYFARE_EXPECTS(period > Duration::zero(), "a sensor needs a positive period");
  LogTime due = truth.empty() ? LogTime{} : truth.front().time + period;
  double forward_m = 0.0, turn_rad = 0.0;
  for (std::size_t i = 1; i < truth.size(); ++i) {
    const Eigen::Vector3d twist = truth[i].T_map_base.raw().minus(truth[i - 1].T_map_base.raw());
    forward_m += twist.x();
    turn_rad += twist.z();
    if (truth[i].time < due) continue;
    visit(truth[i], forward_m, turn_rad);
    forward_m = turn_rad = 0.0;
    due = next_on_grid(due, period, truth[i].time);
  }
}

template <class Turn>
std::vector<OdometrySample> integrate(std::span<const WheelSample> wheels, const Turn& turn_rad) {
  std::vector<OdometrySample> path;
  path.reserve(wheels.size());
  SE2d pose;
  for (std::size_t i = 0; i < wheels.size(); ++i) {
    const double forward_m = 0.5 * (wheels[i].left_m + wheels[i].right_m);
    pose = pose.plus({forward_m, 0.0, turn_rad(i)});
    path.push_back({wheels[i].time, Transform2<frame::Odom, frame::Base>(pose)});
  }
  return path;
}

}  // namespace

Result<Trajectory> drive_route(std::span<const Eigen::Vector2d> route_m, const DriveParams& params,
                               LogTime start) {
  WAYFARE_EXPECTS(params.step > Duration::zero() && params.max_speed_m_s > 0.0 &&
                      params.max_turn_rate_rad_s > 0.0 && params.waypoint_radius_m > 0.0,
                  "a robot needs a positive time step, speeds and waypoint radius");
  if (route_m.size() < 2) return Error{ErrorCode::invalid, "a route needs two waypoints or more"};
  for (std::size_t i = 0; i < route_m.size(); ++i) {
    if (route_m[i].allFinite()) continue;
    return Error{ErrorCode::invalid, "waypoint " + std::to_string(i) + " is not finite"};
  }
  const Eigen::Vector2d heading = route_m[1] - route_m[0];
  SE2d pose(route_m[0].x(), route_m[0].y(), Angle::radians(std::atan2(heading.y(), heading.x())));
  LogTime now = start;
  Trajectory truth{{now, Transform2<frame::Map, frame::Base>(pose)}};
  Driver driver(route_m, params);
  while (!driver.arrived(pose)) {
    pose = driver.advance(pose);
    now += params.step;
    truth.push_back({now, Transform2<frame::Map, frame::Base>(pose)});
    if (now - start <= params.timeout) continue;
    return Error{ErrorCode::degenerate,
                 "waypoint " + std::to_string(driver.target()) + " was not reached in time"};
  }
  return truth;
}

std::vector<WheelSample> simulate_wheels(const Trajectory& truth, Duration period,
                                         const WheelParams& params, Rng& rng) {
  std::vector<WheelSample> samples;
  if (truth.empty()) return samples;
  samples.push_back({truth.front().time, 0.0, 0.0});
  const auto count = [&](double rolled_m, double scale, const Carpet& floor) {
    const double slip_m =
        floor.slip_factor * params.slip_m_per_sqrt_m * std::sqrt(std::abs(rolled_m)) * rng.normal();
    return floor.reported_scale * scale * rolled_m + slip_m;
  };
  for_each_period(truth, period, [&](const StampedPose& at, double forward_m, double turn_rad) {
    const LogTime time = at.time;
    const Carpet floor = floor_at(params.carpets, at.T_map_base.raw().translation());
    const double half_m = 0.5 * params.wheel_base_m * turn_rad;
    const double left_m = count(forward_m - half_m, params.left_scale, floor);
    const double right_m = count(forward_m + half_m, params.right_scale, floor);
    samples.push_back({time, left_m, right_m});
  });
  return samples;
}

std::vector<GyroSample> simulate_gyro(const Trajectory& truth, Duration period,
                                      const GyroParams& params, Rng& rng) {
  std::vector<GyroSample> samples;
  if (truth.empty()) return samples;
  samples.push_back({truth.front().time, 0.0});
  for_each_period(truth, period, [&](const StampedPose& at, double, double turn_rad) {
    const LogTime time = at.time;
    const double dt_s = to_seconds(time - samples.back().time);
    const double walk_rad =
        params.angle_random_walk_rad_per_sqrt_s * std::sqrt(dt_s) * rng.normal();
    samples.push_back({time, params.bias_rad_s + (turn_rad + walk_rad) / dt_s});
  });
  return samples;
}

std::vector<OdometrySample> dead_reckon(std::span<const WheelSample> wheels, double wheel_base_m) {
  WAYFARE_EXPECTS(wheel_base_m > 0.0, "the wheels are some distance apart");
  return integrate(
      wheels, [&](std::size_t i) { return (wheels[i].right_m - wheels[i].left_m) / wheel_base_m; });
}

std::vector<OdometrySample> dead_reckon(std::span<const WheelSample> wheels,
                                        std::span<const GyroSample> gyro) {
  WAYFARE_EXPECTS(wheels.size() == gyro.size(), "wheels and gyro must be sampled together");
  return integrate(wheels, [&](std::size_t i) {
    if (i == 0) return 0.0;
    return gyro[i].turn_rate_rad_s * to_seconds(gyro[i].time - gyro[i - 1].time);
  });
}

SE2d true_pose_at(const Trajectory& trajectory, LogTime time) {
  WAYFARE_EXPECTS(!trajectory.empty(), "a trajectory to look up has at least one pose");
  const LogTime held = std::clamp(time, trajectory.front().time, trajectory.back().time);
  return *pose_at(trajectory, held);
}

}  // namespace wayfare::sim
