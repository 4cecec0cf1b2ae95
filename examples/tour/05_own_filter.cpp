// An extended Kalman filter of one's own: height, climb rate and accelerometer bias of a drone,
// predicted by its accelerometer and corrected by a barometer. The state is a plain vector.
#include <cmath>
#include <cstdio>

#include <wayfare/core/random.hpp>
#include <wayfare/filter/ekf.hpp>

using namespace wayfare;

struct Climb {
  double dt_s;
  struct Step {
    Eigen::Vector3d state;
    Eigen::Matrix3d phi, q;  // x+ = phi x + B u; covariance of the noise
  };
  Step operator()(const Eigen::Vector3d& x, double measured_mps2) const {
    const Eigen::Vector3d by_acceleration(0.5 * dt_s * dt_s, dt_s, 0.0);
    Eigen::Matrix3d phi;
    phi << 1.0, dt_s, 0.0,  //
        0.0, 1.0, 0.0,      //
        0.0, 0.0, 1.0;
    phi.col(2) -= by_acceleration;  // the bias is subtracted from what is measured
    return {phi * x + by_acceleration * measured_mps2, phi,
            Eigen::Vector3d(0.0, 2.5e-7, 1e-9).asDiagonal()};
  }
};

struct Barometer {
  static constexpr int kDim = 1;
  double height_m;
  Eigen::Matrix<double, 1, 1> error(const Eigen::Vector3d& x) const {  // in standard deviations
    return Eigen::Matrix<double, 1, 1>((x[0] - height_m) / 0.5);
  }
};

int main() {
  Ekf<Eigen::Vector3d> filter(Eigen::Vector3d::Zero(), Eigen::Vector3d(1.0, 1.0, 0.1).asDiagonal());
  Rng rng(1);
  double squares = 0.0;
  for (int k = 1; k <= 6000; ++k) {  // a minute at 100 Hz, up and down by 5 m
    const double phase = 0.5 * 0.01 * k, height = 5.0 * std::sin(phase);
    const double acceleration = -0.25 * height;
    filter.predict(Climb{0.01}, acceleration + 0.2 + rng.normal(0.0, 0.05));
    if (k % 10 == 0) filter.update(Barometer{height + rng.normal(0.0, 0.5)});
    if (k > 3000) squares += std::pow(filter.state()[0] - height, 2.0) / 3000;
  }
  const Eigen::Vector3d sigma = filter.covariance().diagonal().cwiseSqrt();
  std::printf("height: %.3f m rms, sigma %.3f m\n", std::sqrt(squares), sigma[0]);
  std::printf("bias: %.3f m/s2, sigma %.3f m/s2\n", filter.state()[2], sigma[2]);
}
