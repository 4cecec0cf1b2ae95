#include "links.hpp"

#include <cmath>

#include <wayfare/graph/factor_graph.hpp>
#include <wayfare/graph/incremental.hpp>
#include <wayfare/graph/optimise.hpp>

// A state, an edge and a robust kernel of one's own: the height of a lift and its speed, from
// readings of which a few are wrong.
namespace {

struct Lift {
  double height_m = 0.0, speed_m_s = 0.0;
};

struct LogCosh {
  double scale = 1.0;
  wayfare::KernelValue operator()(double s) const {
    const double r = std::sqrt(s) / scale;
    return {2.0 * scale * scale * std::log(std::cosh(r)), r > 0.0 ? std::tanh(r) / r : 1.0};
  }
};

}  // namespace

namespace wayfare {
template <>
struct ManifoldTraits<Lift> {
  using Scalar = double;
  static constexpr int kDof = 2;
  using Tangent = Eigen::Vector2d;
  static Lift plus(const Lift& x, const Tangent& tau) {
    return {x.height_m + tau[0], x.speed_m_s + tau[1]};
  }
  static Tangent minus(const Lift& y, const Lift& x) {
    return {y.height_m - x.height_m, y.speed_m_s - x.speed_m_s};
  }
};
}  // namespace wayfare

namespace {

struct Ride {
  using Variables = wayfare::EdgeVariables<Lift, Lift>;
  static constexpr int kDim = 2;
  double seconds = 1.0;
  Eigen::Vector2d error(const Lift& from, const Lift& to) const {
    return {(to.height_m - from.height_m - seconds * from.speed_m_s) / 0.01,
            (to.speed_m_s - from.speed_m_s) / 0.01};
  }
};

struct Barometer {
  using Variables = wayfare::EdgeVariables<Lift>;
  static constexpr int kDim = 1;
  double height_m = 0.0;
  Eigen::Matrix<double, 1, 1> error(const Lift& x) const {
    return Eigen::Matrix<double, 1, 1>((x.height_m - height_m) / 0.1);
  }
};

}  // namespace

bool own_edges() {
  using namespace wayfare;
  FactorGraph<Variables<Lift>, Edges<Ride, Robust<Barometer, LogCosh>>> graph;
  std::vector<VariableId<Lift>> ride;
  for (int i = 0; i < 20; ++i) {
    ride.push_back(graph.add(Lift{}));
    const double wrong = i == 7 ? 30.0 : 0.0;
    graph.add(Robust{Barometer{1.5 * i + wrong}, LogCosh{}}, ride.back());
    if (i > 0) graph.add(Ride{}, ride[ride.size() - 2], ride.back());
  }
  const auto report = optimise(graph);
  // The slope of the kernel is at most one: the wrong reading acts as one that is off by a standard
  // deviation, 0.1 m. Heights within that at both ends of 19 s give the speed within 0.2 m / 19 s.
  IncrementalGraphOptimiser<decltype(graph)> growing;  // at the optimum it stays there
  if (!report || !growing.append(graph) || !growing.update() ||
      std::abs(growing[ride.back()].height_m - graph[ride.back()].height_m) > 0.01)
    return false;
  return std::abs(graph[ride.back()].height_m - 28.5) < 0.1 &&
         std::abs(graph[ride.back()].speed_m_s - 1.5) < 0.01;
}
