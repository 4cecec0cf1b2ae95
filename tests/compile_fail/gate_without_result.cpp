// EXPECT: a gate has a const member operator
#include <wayfare/filter/ekf.hpp>

using Line = Eigen::Matrix<double, 1, 1>;

struct Depth {
  wayfare::ScalarMeasurement<double, wayfare::SparseRow<double, 1>> operator()(
      const Line& x) const {
    return {1.0 - x[0], {{0}, {1.0}}, 0.1};
  }
};

struct Fence {
#ifdef WAYFARE_MUST_FAIL
  void operator()(const wayfare::Innovation<double, 1>&) const {}
#else
  bool operator()(const wayfare::Innovation<double, 1>& i) const { return i.nis < 9.0; }
#endif
};

void update(wayfare::Ekf<Line>& filter) { filter.update(Depth{}, Fence{}); }
