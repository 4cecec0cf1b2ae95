// EXPECT: a measurement has a const member error
#include <wayfare/core/se2.hpp>
#include <wayfare/filter/ekf.hpp>

struct Pose {
  using Value = wayfare::SE2d;
  static constexpr wayfare::BlockNames<3> kNames{"x", "y", "heading"};
};

struct Compass {
  using Blocks = wayfare::BlockList<Pose>;
  static constexpr int kDim = 1;
#ifndef WAYFARE_MUST_FAIL
  Eigen::Matrix<double, 1, 1> error(const wayfare::SE2d& x) const {
    return Eigen::Matrix<double, 1, 1>(x.heading().radians());
  }
#endif
};

void update(wayfare::Ekf<wayfare::State<Pose>>& filter) { filter.update(Compass{}); }
