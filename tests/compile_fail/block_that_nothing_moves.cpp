// EXPECT: each block of a state is moved by exactly one part of its process
#include <wayfare/filter/process.hpp>

struct Bias : wayfare::GaussMarkov<1> {
  static constexpr wayfare::BlockNames<1> kNames{"bias"};
};
struct Scale : wayfare::RandomConstant<1> {
  static constexpr wayfare::BlockNames<1> kNames{"scale"};
};
using Errors = wayfare::State<Bias, Scale>;

#ifndef WAYFARE_MUST_FAIL
const auto step = wayfare::Process<Errors, Bias, Scale>{Bias{}, Scale{}}(Errors{}, 1.0);
#else
const auto step = wayfare::Process<Errors, Bias>{Bias{}}(Errors{}, 1.0);
#endif
