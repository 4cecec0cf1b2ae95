#include "links.hpp"

#include <cmath>

#include <wayfare/filter/ekf.hpp>
#include <wayfare/filter/gates.hpp>

// A gate of one's own: a level gauge that foam makes read too high, never too low.
namespace {

using Level = Eigen::Matrix<double, 1, 1>;

struct Gauge {
  double level_m;
  wayfare::ScalarMeasurement<double, wayfare::SparseRow<double, 1>> operator()(
      const Level& x) const {
    return {level_m - x[0], {{0}, {1.0}}, 0.01};
  }
};

struct NoFoam {
  bool operator()(const wayfare::Innovation<double, 1>& i) const {
    return i.value < 2.0 * std::sqrt(i.covariance);
  }
};

}  // namespace

bool own_gates() {
  wayfare::Ekf<Level> filter(Level(1.0), Level(0.01));
  if (filter.update(Gauge{2.0}, NoFoam{}).accepted || filter.state()[0] != 1.0) return false;
  if (!filter.update(Gauge{0.0}, NoFoam{}).accepted) return false;
  if (filter.update(Gauge{2.0}, wayfare::ChiSquareGate(0.99)).accepted) return false;
  return filter.update(Gauge{2.0}, wayfare::HuberWeight{}).accepted && filter.state()[0] < 1.0;
}
