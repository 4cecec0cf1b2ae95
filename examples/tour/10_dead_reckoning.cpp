// Pedestrian dead reckoning from its parts: steps from the accelerometer, their lengths, and their
// directions from an attitude filter; and the same in one object. A person walks around a square
// with a phone ahead in the hand, and ends at the start.
#include <cmath>
#include <cstdio>
#include <numbers>

#include <wayfare/core/random.hpp>
#include <wayfare/pedestrian/pedestrian.hpp>

using namespace wayfare;

MargRecording walk_around_a_square() {
  constexpr double kStep_hz = 2.0, kPi = std::numbers::pi;
  MargRecording samples;
  Rng rng(1);
  const auto noise = [&rng](double sigma) {
    return Eigen::Vector3d(sigma * rng.normal(), sigma * rng.normal(), sigma * rng.normal());
  };
  double heading = 0.5 * kPi;        // counter-clockwise from east; y of the phone points ahead
  for (int i = 1; i <= 4800; ++i) {  // 4 s at rest, 11 s along each side, the last one a turn
    const double t = 0.01 * i - 4.0;
    const bool walking = t > 0.0, turning = walking && std::fmod(t, 11.0) >= 10.0;
    const double turn_radps = turning ? 0.5 * kPi : 0.0;
    heading += 0.01 * turn_radps;
    const SO3d q_world_phone = SO3d::exp({0.0, 0.0, heading - 0.5 * kPi});
    const double bounce = walking ? 3.0 * std::cos(2.0 * kPi * kStep_hz * t) : 0.0;
    const Eigen::Vector3d field_uT(0.0, 20.0, -44.0);  // east, north, up
    samples.push_back({LogTime::from_seconds(0.01 * i),
                       Eigen::Vector3d(0.0, 0.0, turn_radps) + noise(0.01),
                       Eigen::Vector3d(0.0, 0.0, 9.80665 + bounce) + noise(0.1),
                       q_world_phone.inverse() * field_uT + noise(0.5)});
  }
  return samples;
}

int main() {
  Ahrs<frame::Enu> attitude;
  StepDetector steps(walking_step_parameters());
  const ConstantStep length{0.7};
  Eigen::Vector2d position(0.0, 0.0);
  double distance = 0.0;
  PedestrianParameters parameters;
  parameters.length = length;
  Pedestrian pedestrian(parameters);
  for (const MargSample& sample : walk_around_a_square()) {
    attitude.add(sample);
    steps.add(sample.time, sample.specific_force_mps2, [&](const Step& step) {
      const Eigen::Vector3d ahead = attitude.q_world_body() * Eigen::Vector3d::UnitY().eval();
      position += length(step) * ahead.head<2>().normalized();
      distance += length(step);
    });
    pedestrian.add(sample);
  }
  std::printf("%d steps, %.0f m, %.1f m from the start; Pedestrian %.0f m, %.1f m\n",
              static_cast<int>(steps.steps()), distance, position.norm(),
              pedestrian.report().distance_m, pedestrian.pose().position_m.norm());
}
