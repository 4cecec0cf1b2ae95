// EXPECT: a block has a name for each of its errors, static constexpr BlockNames<n> kNames
#include <wayfare/core/se2.hpp>
#include <wayfare/filter/state.hpp>

struct Pose {
  using Value = wayfare::SE2d;
#ifndef WAYFARE_MUST_FAIL
  static constexpr wayfare::BlockNames<3> kNames{"x", "y", "heading"};
#endif
};

wayfare::State<Pose> state;
