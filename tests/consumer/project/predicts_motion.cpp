#include "links.hpp"

#include <cmath>

#include <wayfare/filter/ekf.hpp>
#include <wayfare/inertial.hpp>

// At rest at latitude 30°, level, heading north, a unit measures the Earth's rotation and the
// reaction to gravity. With them a filter on 23 errors stays for a second.
bool predicts_motion() {
  using wayfare::Angle;
  constexpr double kEarthRate = 7.292115e-5;
  const wayfare::LocalTangentPlane plane({Angle::degrees(30.0), Angle::degrees(0.0), 0.0});
  const Eigen::Vector3d rate(kEarthRate * std::sqrt(0.75), 0.0, -kEarthRate / 2);
  const Eigen::Vector3d force(0.0, 0.0, -wayfare::normal_gravity_mps2(0.5, 0.0));
  using State = wayfare::InsState<double, 0>;
  wayfare::Ekf<State> filter(State{}, wayfare::SquareOf<State>::Identity());
  const wayfare::InsModel<double> model(plane, wayfare::InsNoise<double>({}, {}));
  for (int i = 0; i < 100; ++i)
    filter.predict(model, wayfare::ImuInterval{rate, rate, force, force, 0.01});
  // Position north from errors of 1 at t = 0: 1 + t² (velocity) + (t²/2)² (accelerometer) +
  // (g t²/2)² (tilt) + (g t³/6)² (gyro); steps of 10 ms integrate to better than 1 %.
  const double g = -force.z();
  const double expected = 2.25 + g * g * (1.0 / 4.0 + 1.0 / 36.0);
  return filter.state().position_m.norm() < 1e-6 && filter.state().velocity_mps.norm() < 1e-6 &&
         std::abs(filter.covariance()(0, 0) / expected - 1.0) < 0.01;
}
