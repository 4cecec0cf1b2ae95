#include <wayfare/sim/walks.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include <wayfare/core/atmosphere.hpp>
#include <wayfare/core/contract.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/sim/vehicle_trajectory.hpp>

namespace wayfare::sim {
namespace {

using Vector = Eigen::Vector3d;

constexpr double kGravity = 9.80665;
constexpr double kMaxSamples = 1e7;

struct Pose {
  Vector p, v;
  SO3d q;
};

/// Strides on the given flight before a point of the walk.
double strides_on(const StairFlight& flight, double strides) {
  return std::clamp(strides - flight.first, 0.0, static_cast<double>(flight.strides));
}
/// Level strides of the same horizontal length.
double level_strides(const FeetPlan& plan, double strides) {
  double level = strides;
  for (const StairFlight& flight : plan.stairs)
    level -= (1.0 - flight.tread_m / plan.stride_m) * strides_on(flight, strides);
  return level;
}
double climbed_m(const FeetPlan& plan, double strides) {
  double height = 0.0;
  for (const StairFlight& flight : plan.stairs)
    height += flight.rise_m * strides_on(flight, strides);
  return height;
}

/// One foot's path: its position after each stride, and the times of its swings.
class Foot {
 public:
  Foot(const FeetPlan& plan, bool left) : plan_(plan) {
    late_s_ = left ? 0.0 : 0.5 * (plan.swing_s + plan.stance_s);
    const double side_m = (left ? 0.5 : -0.5) * plan.width_m;
    // The left foot starts and the right one ends with half a stride, and they end side by side.
    for (int i = 0; i <= plan.strides; ++i) {
      const double strides = left ? std::max(0.0, i - 0.5) : std::min(i * 1.0, plan.strides - 0.5);
      const double heading = level_strides(plan, strides) * plan.turn_rad;
      headings_.push_back(heading);
      stands_.emplace_back(along(strides) +
                           side_m * Vector(-std::sin(heading), std::cos(heading), 0.0));
    }
  }

  [[nodiscard]] const Vector& begin() const { return stands_.front(); }

  [[nodiscard]] Pose at(double t) const {
    const double stride_s = plan_.swing_s + plan_.stance_s;
    const double since = std::max(0.0, t - plan_.rest_s - late_s_);
    const int n = std::min(plan_.strides, static_cast<int>(since / stride_s));
    const bool done = n == plan_.strides;
    const double u = done ? 0.0 : std::min(1.0, (since - n * stride_s) / plan_.swing_s);
    const double step = u * u * u * (10.0 + u * (-15.0 + 6.0 * u));
    const double step_rate = 30.0 * u * u * (1.0 - u) * (1.0 - u) / plan_.swing_s;
    const double hump = 64.0 * std::pow(u * (1.0 - u), 3);
    const double hump_rate = 192.0 * std::pow(u * (1.0 - u), 2) * (1.0 - 2.0 * u) / plan_.swing_s;
    const auto from = static_cast<std::size_t>(n);
    const auto next = done ? from : from + 1;
    const Vector along = stands_[next] - stands_[from];
    const Vector up(0.0, 0.0, plan_.lift_m);
    // A foot in stance rolls a little about its point of contact.
    constexpr double kSway_hz = 0.8;
    const double sway = plan_.sway_radps / (2.0 * std::numbers::pi * kSway_hz) *
                        std::sin(2.0 * std::numbers::pi * kSway_hz * (t + late_s_));
    return {stands_[from] + step * along + hump * up, step_rate * along + hump_rate * up,
            SO3d::exp({0.0, 0.0, (1.0 - step) * headings_[from] + step * headings_[next]}) *
                SO3d::exp({sway, plan_.pitch_rad * hump, 0.0})};
  }

 private:
  /// The midpoint between the feet after this number of strides: on a circle or straight.
  [[nodiscard]] Vector along(double strides) const {
    const double level = level_strides(plan_, strides), height_m = climbed_m(plan_, strides);
    const double angle = level * plan_.turn_rad, length_m = level * plan_.stride_m;
    if (std::abs(plan_.turn_rad) < 1e-12) return {length_m, 0.0, height_m};
    const double radius = plan_.stride_m / plan_.turn_rad;
    return {radius * std::sin(angle), radius * (1.0 - std::cos(angle)), height_m};
  }

  FeetPlan plan_;
  double late_s_ = 0.0;
  std::vector<Vector> stands_;
  std::vector<double> headings_;
};

FootTruth walk(const Foot& foot, const FeetPlan& plan, double duration_s, const ImuNoise& noise,
               Rng rng) {
  ImuErrorProcess errors(noise, rng);
  FootTruth truth;
  const double dt = 1.0 / plan.rate_hz;
  const auto count = static_cast<int>(duration_s * plan.rate_hz);
  for (int i = 1; i <= count; ++i) {
    const Pose before = foot.at((i - 1) * dt), after = foot.at(i * dt);
    const Vector turn = (before.q.inverse() * after.q).log();
    const SO3d middle = before.q * SO3d::exp(0.5 * turn);
    const Vector rate = turn / dt;
    const Vector force = middle.inverse() * ((after.v - before.v) / dt + Vector(0, 0, kGravity));
    errors.step(dt, rng);
    truth.samples.push_back(errors.measure(
        {LogTime::from_nanoseconds(std::llround(i * dt * 1e9)), rate, force}, dt, rng));
    truth.position.emplace_back(after.p - foot.begin());
  }
  return truth;
}

constexpr double kStart_s = 1.5;  // from rest to walking

SO3d about(const Eigen::Vector3d& axis, double angle) { return SO3d::exp(axis * angle); }

}  // namespace

FeetTruth simulate_feet(const FeetPlan& plan, const ImuNoise& noise, const Rng& rng) {
  WAYFARE_EXPECTS(plan.rate_hz > 0.0 && plan.strides > 0 && plan.swing_s > 0.0,
                  "feet need a positive rate, strides and a swing");
  const double stride_s = plan.swing_s + plan.stance_s;
  const double duration_s = 2.0 * plan.rest_s + (plan.strides + 0.5) * stride_s;
  WAYFARE_EXPECTS(
      plan.stance_s >= 0.0 && plan.rest_s >= 0.0 && duration_s * plan.rate_hz < kMaxSamples,
      "stance and rest are not negative, and a walk has up to ten million samples");
  const Foot left(plan, true), right(plan, false);
  return {walk(left, plan, duration_s, noise, rng.stream(0)),
          walk(right, plan, duration_s, noise, rng.stream(1)), right.begin() - left.begin(),
          level_strides(plan, plan.strides - 0.5) * plan.stride_m};
}

std::vector<double> simulate_pressure(std::span<const double> heights_m, double dt_s,
                                      const BarometerNoise& noise, Rng& rng) {
  constexpr double kReference_Pa = 101325.0;
  std::vector<double> pressures;
  double drift = 0.0;
  for (const double height : heights_m) {
    drift += noise.drift_Pa * std::sqrt(dt_s) * rng.normal();
    pressures.push_back(barometric_pressure_Pa(height, kReference_Pa) + drift +
                        noise.white_Pa * rng.normal());
  }
  return pressures;
}

HeadWalk::HeadWalk(std::vector<Eigen::Vector2d> route_m, const HeadWalkParams& params, Rng rng)
    : p_(params), route_m_(std::move(route_m)) {
  // A waypoint given twice has no direction.
  route_m_.erase(std::unique(route_m_.begin(), route_m_.end()), route_m_.end());
  along_.push_back(0.0);
  for (std::size_t i = 1; i < route_m_.size(); ++i)
    along_.push_back(along_.back() + (route_m_[i] - route_m_[i - 1]).norm());
  WAYFARE_EXPECTS(route_m_.size() >= 2 && std::isfinite(along_.back()) && p_.speed_m_s > 0.0,
                  "a walk needs two distinct waypoints and a speed");
  yaw_ = waves(p_.glance.radians(), rng);
  pitch_ = waves(p_.pitch.radians(), rng);
  roll_ = waves(p_.roll.radians(), rng);
  const double pitch = rng.normal(), roll = rng.normal();
  q_head_unit_ = SO3d::exp(p_.mounting_sigma.radians() * Eigen::Vector3d(roll, pitch, 0.0));
  phase_ = 2 * std::numbers::pi * rng.uniform();
  duration_s_ = 2 * p_.rest_s + kStart_s + along_.back() / p_.speed_m_s;
}

/// Five waves of 2.5 to 12 s.
std::vector<HeadWalk::Wave> HeadWalk::waves(double sigma, Rng& rng) {
  std::vector<Wave> result;
  for (int k = 0; k < 5; ++k) {
    const double period = 2.5 + 9.5 * rng.uniform();
    result.push_back({sigma * std::sqrt(2.0 / 5), 2 * std::numbers::pi / period,
                      2 * std::numbers::pi * rng.uniform()});
  }
  return result;
}

double HeadWalk::sum(const std::vector<Wave>& waves, double time_s) {
  double total = 0.0;
  for (const Wave& w : waves) total += w.amplitude * std::sin(w.rate * time_s + w.phase);
  return total;
}

/// Speed over time: at rest, accelerating along a cosine, decelerating.
double HeadWalk::travelled(double time_s) const {
  const auto ramp = [&](double t) {  // the integral of (1 - cos) / 2 over the start
    if (t <= 0) return 0.0;
    if (t >= kStart_s) return t - kStart_s / 2;
    return t / 2 - kStart_s / (2 * std::numbers::pi) * std::sin(std::numbers::pi * t / kStart_s);
  };
  const double walking = along_.back() / p_.speed_m_s;
  const double t = time_s - p_.rest_s;
  return p_.speed_m_s * (ramp(t) - ramp(t - walking));
}

Eigen::Vector2d HeadWalk::on_route(double s) const {
  const auto after = std::upper_bound(along_.begin() + 1, along_.end() - 1, s);
  const auto i = static_cast<std::size_t>(after - along_.begin());
  const double u = (s - along_[i - 1]) / (along_[i] - along_[i - 1]);
  return route_m_[i - 1] + u * (route_m_[i] - route_m_[i - 1]);
}

/// The route smoothed by a triangular window: its second derivative is continuous.
Eigen::Vector2d HeadWalk::rounded(double s) const {
  constexpr int kHalf = 40;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  double weights = 0.0;
  for (int k = -kHalf; k <= kHalf; ++k) {
    const double w = kHalf + 1 - std::abs(k);
    mean += w * on_route(s + p_.corner_m * k / kHalf);
    weights += w;
  }
  return mean / weights;
}

HeadWalk::Pose HeadWalk::at(double time_s) const {
  const double s = travelled(time_s);
  const double pace = (travelled(time_s + 0.05) - travelled(time_s - 0.05)) / (0.1 * p_.speed_m_s);
  const double step = 2 * std::numbers::pi * s / p_.step_m + 0.4 * std::sin(s / 2.3 + phase_);
  // A walker looks in the direction of the path a little later.
  const Eigen::Vector2d ahead = rounded(s + 0.7) - rounded(s - 0.1);
  const double heading = std::atan2(ahead.y(), ahead.x());
  const Eigen::Vector2d left(-std::sin(heading), std::cos(heading));
  const double moved = std::min(1.0, time_s / p_.rest_s);  // stands still at first
  Pose pose;
  const Eigen::Vector2d place = rounded(s) + pace * p_.sway_m * std::sin(step / 2) * left;
  pose.position_m << place, p_.height_m + pace * p_.bob_m * std::sin(step);
  const double yaw = heading + moved * pace * sum(yaw_, time_s);
  const double pitch =
      moved * sum(pitch_, time_s) * (0.2 + 0.8 * pace) + pace * p_.nod.radians() * std::cos(step);
  const double roll = moved * sum(roll_, time_s) * (0.2 + 0.8 * pace);
  pose.q_world_head = about(Eigen::Vector3d::UnitZ(), yaw) *
                      about(Eigen::Vector3d::UnitY(), pitch) *
                      about(Eigen::Vector3d::UnitX(), roll) * q_head_unit_;
  return pose;
}

MargRecording HeadWalk::unit(double rate_hz, const UnitNoise& noise, Rng& rng) const {
  WAYFARE_EXPECTS(rate_hz > 0.0 && duration_s_ * rate_hz < kMaxSamples,
                  "a walk has up to ten million samples");
  constexpr double kStep_s = 0.004;
  MargRecording readings;
  const auto white = [&](double sigma) {
    const double z = rng.normal(), y = rng.normal(), x = rng.normal();
    return Eigen::Vector3d(sigma * Eigen::Vector3d(x, y, z));
  };
  const Eigen::Vector3d bias = white(noise.gyro_bias_per_second.radians());
  const bool biased = noise.accel_bias_mps2 > 0;
  const Eigen::Vector3d accel_bias =
      biased ? white(noise.accel_bias_mps2) : Eigen::Vector3d(Eigen::Vector3d::Zero());
  const auto count = static_cast<int>(duration_s_ * rate_hz);
  for (int i = 0; i < count; ++i) {
    const double t = i / rate_hz;
    const Pose before = at(t - kStep_s), here = at(t), after = at(t + kStep_s);
    MargSample sample;
    sample.time = LogTime::from_seconds(t);
    sample.angular_rate_radps =
        (before.q_world_head.inverse() * after.q_world_head).log() / (2 * kStep_s) + bias +
        white(noise.gyro_radps);
    const Eigen::Vector3d acceleration =
        (after.position_m - 2 * here.position_m + before.position_m) / (kStep_s * kStep_s);
    sample.specific_force_mps2 =
        here.q_world_head.inverse() * (acceleration + kGravity * Eigen::Vector3d::UnitZ()) +
        accel_bias + white(noise.accel_mps2);
    readings.push_back(sample);
  }
  return readings;
}

namespace {

/// Without ranges yet.
LaserScan empty_head_scan(LogTime time, const HeadLidarParams& params) {
  LaserScan scan{time,
                 Angle::degrees(-180),
                 Angle::degrees(360.0 / params.beams),
                 static_cast<float>(params.min_range_m),
                 static_cast<float>(params.max_range_m),
                 {}};
  scan.ranges_m.resize(static_cast<std::size_t>(std::max(params.beams, 0)));
  return scan;
}

/// NaN without return.
float range_from_head(const FloorPlan& plan, const HeadWalk::Pose& head, double bearing,
                      const HeadLidarParams& params, Rng& rng) {
  const Eigen::Vector3d beam =
      head.q_world_head * Eigen::Vector3d(std::cos(bearing), std::sin(bearing), 0.0);
  const double flat = beam.head<2>().norm(), up = beam.z(), z = head.position_m.z();
  double range =
      plan.cast(head.position_m.head<2>(), beam.head<2>() / flat, params.max_range_m * flat) / flat;
  if (up < 0) range = std::min(range, -z / up);
  if (up > 0) range = std::min(range, (params.ceiling_m - z) / up);
  range +=
      (params.noise_m + params.noise_per_m * std::min(range, params.max_range_m)) * rng.normal();
  return range < params.max_range_m ? static_cast<float>(range)
                                    : std::numeric_limits<float>::quiet_NaN();
}

}  // namespace

LaserScan scan_from_head(const FloorPlan& plan, const HeadWalk::Pose& head, LogTime time,
                         const HeadLidarParams& params, Rng& rng) {
  LaserScan scan = empty_head_scan(time, params);
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i)
    scan.ranges_m[i] = range_from_head(plan, head, scan.bearing(i).radians(), params, rng);
  return scan;
}

LaserScan sweep_from_head(const FloorPlan& plan, const HeadWalk& walk, LogTime time,
                          const HeadLidarParams& params, Rng& rng) {
  LaserScan scan = empty_head_scan(time, params);
  scan.time_increment = params.sweep / std::max(params.beams - 1, 1);
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i)
    scan.ranges_m[i] = range_from_head(plan, walk.at(scan.beam_time(i).seconds()),
                                       scan.bearing(i).radians(), params, rng);
  return scan;
}

}  // namespace wayfare::sim
