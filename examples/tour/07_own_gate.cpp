// A robot between beacons whose ranges are often reflected: a gate of one's own. Reflected ranges
// are only ever longer, so that long ones lose weight, the more the longer they are.
#include <cmath>
#include <cstdio>

#include <wayfare/core/random.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/filter/ekf.hpp>

using namespace wayfare;
struct Range {
  using Jacobians = AutomaticJacobians;
  static constexpr int kDim = 1;
  Eigen::Vector2d beacon_m;
  double range_m;
  template <class T>
  Eigen::Matrix<T, 1, 1> error(const SE2<T>& robot) const {  // in standard deviations
    const Eigen::Matrix<T, 2, 1> apart = beacon_m.cast<T>() - robot.translation();
    return Eigen::Matrix<T, 1, 1>((apart.norm() - T(range_m)) / T(0.1));
  }
};
struct Drive {
  struct Step {
    SE2d state;
    Eigen::Matrix3d phi, q;
  };
  Step operator()(const SE2d& x, const SE2d& motion) const {
    return {x * motion, motion.inverse().adjoint(), Eigen::Vector3d(4e-4, 1e-6, 1e-4).asDiagonal()};
  }
};
struct EchoWeight {  // of R
  double operator()(const Innovation<double, 1>& i) const {
    const double sigmas = i.value / std::sqrt(i.covariance);
    return sigmas > 1.0 ? 1.0 / (sigmas * sigmas) : 1.0;
  }
};
template <class Gate>
double rms_error_m(const Gate& gate) {
  const SE2d motion(0.5, 0.0, Angle::degrees(4));
  Ekf<SE2d> filter(SE2d(), 0.01 * Eigen::Matrix3d::Identity());
  double sum = 0.0;
  SE2d truth;
  Rng rng(1);
  for (int step = 0; step < 1000; ++step) {
    truth = truth * motion;
    filter.predict(Drive{}, motion.plus({0.02 * rng.normal(), 0.0, 0.01 * rng.normal()}));
    for (const Eigen::Vector2d& beacon : {Eigen::Vector2d(-3, 8), {9, 12}, {2, -4}}) {
      const double echo = rng.below(3) == 0 ? rng.uniform(0.0, 1.0) : 0.0;
      const double range = (beacon - truth.translation()).norm() + 0.1 * rng.normal() + echo;
      filter.update(Range{beacon, range}, gate);
    }
    sum += (filter.state().translation() - truth.translation()).squaredNorm() / 1000;
  }
  return std::sqrt(sum);
}

int main() {
  std::printf("limit of 3 sigma: error %.3f m; ", rms_error_m(3.0));
  std::printf("EchoWeight: error %.3f m\n", rms_error_m(EchoWeight{}));
}
