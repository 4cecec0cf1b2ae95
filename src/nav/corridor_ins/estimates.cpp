#include <wayfare/nav/corridor_ins.hpp>

#include "nav/corridor_ins/motion_watch.hpp"
#include "nav/corridor_ins/wall_states.hpp"

namespace wayfare {

using namespace corridor;

SE2d CorridorIns::pose() const {
  return SE2d(state().get<Position>(), SO2d(Angle::radians(state().get<Heading>()[0])));
}

Eigen::Matrix3d CorridorIns::pose_covariance() const {
  constexpr auto kAt = CorridorState::indices<Position, Heading>();
  return covariance()(kAt, kAt);
}

Eigen::Matrix<double, 5, 5> CorridorIns::joint_covariance() const {
  constexpr auto kAt = CorridorState::indices<Position, Heading, BiasWalk, Scale, Bias>();
  Eigen::Matrix<double, 5, 7> pick = Eigen::Matrix<double, 5, 7>::Identity();
  pick(3, 5) = 1.0;
  return pick * covariance()(kAt, kAt) * pick.transpose();
}
Estimate CorridorIns::gyro_bias() const {
  constexpr auto kAt = CorridorState::indices<BiasWalk, Bias>();
  const Eigen::Matrix3d p = covariance()(kAt, kAt);
  return {state().get<BiasWalk>()[0] + state().get<Bias>()[0],
          sigma_of(p(0, 0) + p(1, 1) + 2.0 * p(0, 1))};
}
Estimate CorridorIns::gyro_drift() const {
  return {state().get<Bias>()[1], sigma_of(variances<Bias>(covariance())[1])};
}
Estimate CorridorIns::speed_scale() const {
  return {state().get<Scale>()[0], sigma_of(variances<Scale>(covariance())[0])};
}

}  // namespace wayfare
