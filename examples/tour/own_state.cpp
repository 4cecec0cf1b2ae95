// A cart that sees the positions of beacons: a state composed of a block of one's own and the
// library's, moved by odometry, with a vector measurement. All Jacobians are automatic.
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
struct WheelScale : RandomConstant<1> {
  static constexpr BlockNames<1> kNames{"wheel scale (1)"};
};
using Cart = State<Pose, GyroBias, WheelScale>;

struct Odometry {
  double dt_s, speed_mps, turn_rate_radps;
};
struct Drive {  // moves the pose
  using Moves = BlockList<Pose>;
  using By = BlockList<Pose, GyroBias, WheelScale>;
  using Jacobians = AutomaticJacobians;
  template <class T>
  SE2<T> moved(const SE2<T>& pose, const auto& bias, const auto& scale, const Odometry& u) const {
    return pose.plus(Eigen::Matrix<T, 3, 1>(u.dt_s * u.speed_mps * (T(1) + scale[0]), T(0),
                                            u.dt_s * (T(u.turn_rate_radps) - bias[0])));
  }
  Eigen::Vector3d noise(const auto&, const auto&, const auto&, const Odometry& u) const {
    return u.dt_s * Eigen::Vector3d(1e-4, 1e-6, 1e-6);  // variances
  }
};
struct BeaconPosition {  // in the cart's frame
  using Blocks = BlockList<Pose>;
  using Jacobians = AutomaticJacobians;
  static constexpr int kDim = 2;
  Eigen::Vector2d beacon_m, measured_m;
  Eigen::Matrix2d covariance = 0.01 * Eigen::Matrix2d::Identity();
  template <class T>
  Eigen::Matrix<T, 2, 1> error(const SE2<T>& pose) const {
    return pose.inverse() * beacon_m.cast<T>() - measured_m.cast<T>();
  }
};

int main() {
  const Process<Cart, Drive, GyroBias, WheelScale> process{{}, {{0.02, 1000.0}}, {}};
  const Cart::Tangent sigma = (Cart::Tangent() << 0.1, 0.1, 0.1, 0.02, 0.1).finished();
  Ekf<Cart> filter(Cart{}, sigma.cwiseAbs2().asDiagonal());
  Cart truth;
  truth.get<GyroBias>()[0] = 0.02;
  truth.get<WheelScale>()[0] = 0.05;
  Rng rng(1);
  for (int i = 0; i < 600; ++i) {
    truth.get<Pose>() = truth.get<Pose>().plus({0.105, 0.0, 0.02});
    filter.predict(process, Odometry{0.1, 1.0, 0.22});
    const Eigen::Vector2d beacon(6.0, -3.0), noise(0.1 * rng.normal(), 0.1 * rng.normal());
    const Eigen::Vector2d seen = truth.get<Pose>().inverse() * beacon + noise;
    if (i % 10 == 0) filter.update(BeaconPosition{beacon, seen});
  }
  const Cart::Tangent error = filter.state().minus(truth);
  for (int i = 0; i < Cart::kDof; ++i)
    std::printf("%-18s error %8.4f, sigma %.4f\n", Cart::names()[i].data(), error[i],
                std::sqrt(filter.covariance()(i, i)));
}
