// A cart that sees a beacon: a state of a block of one's own and one of the library's, moved by
// odometry, with a vector measurement. The Jacobians are automatic.
#include <cmath>
#include <cstdio>

#include <wayfare/core/random.hpp>
#include <wayfare/core/se2.hpp>
#include <wayfare/filter/ekf.hpp>
#include <wayfare/filter/process.hpp>

using namespace wayfare;
struct Pose {
  using Value = SE2d;
  static constexpr BlockNames<3> kNames{"x (m)", "y (m)", "heading (rad)"};
};
struct GyroBias : GaussMarkov<1> {
  static constexpr BlockNames<1> kNames{"gyro bias (rad/s)"};
};
using Cart = State<Pose, GyroBias>;
struct Odometry {
  double dt_s, speed_mps, turn_rate_radps;
};
struct Drive {
  using Moves = BlockList<Pose>;
  using By = BlockList<Pose, GyroBias>;
  using Jacobians = AutomaticJacobians;
  template <class T>
  SE2<T> moved(const SE2<T>& x, const Eigen::Matrix<T, 1, 1>& bias, const Odometry& u) const {
    return x.plus({T(u.dt_s * u.speed_mps), T(0), u.dt_s * (u.turn_rate_radps - bias[0])});
  }
  Eigen::Vector3d noise(const auto&, const auto&, const Odometry& u) const {
    return u.dt_s * Eigen::Vector3d(1e-4, 1e-6, 1e-6);  // variances
  }
};
struct BeaconPosition {  // in the cart's frame; the error is in standard deviations
  using Blocks = BlockList<Pose>;
  using Jacobians = AutomaticJacobians;
  static constexpr int kDim = 2;
  Eigen::Vector2d beacon_m, seen_m;
  template <class T>
  Eigen::Matrix<T, 2, 1> error(const SE2<T>& pose) const {
    return (pose.inverse() * beacon_m.cast<T>() - seen_m.cast<T>()) / T(0.1);
  }
};

int main() {
  const Process<Cart, Drive, GyroBias> process{{}, {{0.02, 1000.0}}};
  Ekf<Cart> filter(Cart{}, 0.01 * SquareOf<Cart>::Identity());
  SE2d truth;
  Rng rng(1);
  for (int i = 0; i < 600; ++i) {  // a minute of circles; the gyro is off by 0.05 rad/s
    truth = truth.plus({0.1, 0.0, 0.02});
    filter.predict(process, Odometry{0.1, 1.0, 0.25});
    const Eigen::Vector2d beacon(6.0, -3.0), noise(0.1 * rng.normal(), 0.1 * rng.normal());
    if (i % 10 == 0) filter.update(BeaconPosition{beacon, truth.inverse() * beacon + noise});
  }
  for (int i = 0; const auto name : Cart::names())
    std::printf("%s: sigma %.4f\n", name.data(), std::sqrt(filter.covariance().diagonal()[i++]));
  std::printf("gyro bias %.3f rad/s\n", filter.state().get<GyroBias>()[0]);
}
