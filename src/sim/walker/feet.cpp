#include <wayfare/sim/walks.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

#include <wayfare/core/contract.hpp>
#include <wayfare/core/so3.hpp>
#include <wayfare/sim/vehicle_trajectory.hpp>

namespace wayfare::sim {
namespace {

using Vector = Eigen::Vector3d;

constexpr double kGravity = 9.80665;

struct Pose {
  Vector p, v;
  SO3d q;
};

Vector white(Rng& rng) {
  Vector w;
  for (double& x : w) x = rng.normal();
  return w;
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
      const double heading = strides * plan.turn_rad;
      headings_.push_back(heading);
      stands_.push_back(along(strides) +
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
    const double angle = strides * plan_.turn_rad, length_m = strides * plan_.stride_m;
    if (std::abs(plan_.turn_rad) < 1e-12) return {length_m, 0.0, 0.0};
    const double radius = plan_.stride_m / plan_.turn_rad;
    return {radius * std::sin(angle), radius * (1.0 - std::cos(angle)), 0.0};
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
    const ImuErrors& e = errors.errors();
    const Vector rate_noise = noise.gyro_white_rad_per_sqrt_s.cwiseProduct(white(rng));
    const Vector force_noise = noise.accel_white_mps_per_sqrt_s.cwiseProduct(white(rng));
    truth.samples.push_back(
        {LogTime::from_nanoseconds(std::llround(i * dt * 1e9)),
         rate + rate.cwiseProduct(e.gyro_scale) + e.gyro_bias_radps + rate_noise / std::sqrt(dt),
         force + force.cwiseProduct(e.accel_scale) + e.accel_bias_mps2 +
             force_noise / std::sqrt(dt)});
    truth.position.push_back(after.p - foot.begin());
  }
  return truth;
}

}  // namespace

FeetTruth simulate_feet(const FeetPlan& plan, const ImuNoise& noise, const Rng& rng) {
  WAYFARE_EXPECTS(plan.rate_hz > 0.0 && plan.strides > 0 && plan.swing_s > 0.0,
                  "feet need a positive rate, strides and a swing");
  const double stride_s = plan.swing_s + plan.stance_s;
  const Foot left(plan, true), right(plan, false);
  const double duration_s = 2.0 * plan.rest_s + (plan.strides + 0.5) * stride_s;
  return {walk(left, plan, duration_s, noise, rng.stream(0)),
          walk(right, plan, duration_s, noise, rng.stream(1)), right.begin() - left.begin(),
          (plan.strides - 0.5) * plan.stride_m};
}

}  // namespace wayfare::sim
