// EXPECT: a coupling has a const member noise
#include <wayfare/filter/process.hpp>

struct Level {
  using Value = Eigen::Matrix<double, 1, 1>;
  static constexpr wayfare::BlockNames<1> kNames{"level"};
};

struct Fill {
  using Moves = wayfare::BlockList<Level>;
  using By = wayfare::BlockList<Level>;
  Level::Value moved(const Level::Value& level, double dt_s) const {
    return level + Level::Value(dt_s);
  }
#ifndef WAYFARE_MUST_FAIL
  Level::Value noise(const Level::Value&, double dt_s) const { return Level::Value(dt_s); }
#endif
};

using Tank = wayfare::State<Level>;
const auto step = wayfare::Process<Tank, Fill>{Fill{}}(Tank{}, 1.0);
