// EXPECT: a robust kernel has a const member operator
#include <wayfare/graph/edges.hpp>
#include <wayfare/graph/factor_graph.hpp>

struct Capped {
#ifdef WAYFARE_MUST_FAIL
  double operator()(double s) const { return s < 9.0 ? s : 9.0; }
#else
  wayfare::KernelValue operator()(double s) const {
    return s < 9.0 ? wayfare::KernelValue{s, 1.0} : wayfare::KernelValue{9.0, 0.0};
  }
#endif
};

const auto edge = wayfare::Robust{wayfare::BearingRange{}, Capped{}};
