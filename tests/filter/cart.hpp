#pragma once

// Blocks of a cart's state, of all kinds.

#include <Eigen/Core>

#include <wayfare/core/se2.hpp>
#include <wayfare/filter/blocks.hpp>
#include <wayfare/filter/state.hpp>

namespace wayfare::tests {

template <class T>
using One = Eigen::Matrix<T, 1, 1>;

struct Pose {
  using Value = SE2d;
  static constexpr BlockNames<3> kNames{"x", "y", "heading"};
};
struct Speed {
  struct Storage {
    Eigen::Vector2d speed_mps = Eigen::Vector2d::Zero();
  };
  using Value = Eigen::Vector2d;
  static constexpr auto kMember = &Storage::speed_mps;
  static constexpr BlockNames<2> kNames{"speed forward", "speed left"};
};
struct Bias : GaussMarkov<1> {
  static constexpr BlockNames<1> kNames{"gyro bias"};
};
struct Scale : RandomConstant<1> {
  static constexpr BlockNames<1> kNames{"wheel scale"};
};
struct Drift : RandomWalk<2> {
  static constexpr BlockNames<2> kNames{"drift x", "drift y"};
};
struct Clock : ReceiverClockBlock<1> {
  static constexpr BlockNames<3> kNames{"clock bias", "clock drift", "clock offset"};
};
using Cart = State<Pose, Bias, Speed, Scale, Drift, Clock>;

}  // namespace wayfare::tests
