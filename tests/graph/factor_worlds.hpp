#pragma once

// Simulated walks past points, as factor graphs of several kinds that grow.

#include <cstddef>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/graph/edges.hpp>
#include <wayfare/graph/factor_graph.hpp>
#include <wayfare/graph/incremental.hpp>
#include <wayfare/testing/incremental_laws.hpp>

namespace wayfare::tests {

using Scalar = Eigen::Matrix<double, 1, 1>;

/// Adds to an incremental optimiser and to a plain graph alike.
template <class AnyGraph>
struct Both {
  using Graph = AnyGraph;
  IncrementalGraphOptimiser<Graph> tested;
  Graph model;

  template <class X>
  VariableId<X> add(const X& x, bool held = false) {
    const auto added = tested.add(x, held);
    EXPECT_TRUE(added);
    const VariableId<X> expected = model.add(x);
    if (held) model.fix(expected);
    EXPECT_EQ(added->index, expected.index);
    return expected;
  }
  template <class E, class... X>
  void join(const E& edge, const VariableId<X>&... variables) {
    const auto added = tested.add(edge, variables...);
    EXPECT_TRUE(added) << added.error().message;
    if (added) model.add(edge, variables...);
  }
};

/// Bearings and ranges of trees, some of them wrong.
struct Trees {
  using Pose = SE2d;
  using Point = Eigen::Vector2d;
  static constexpr bool kScaled = false;
  using Graph = FactorGraph<Variables<SE2d, Point>, Edges<Between<SE2d>, Robust<BearingRange>>>;

  static void move(Both<Graph>& g, VariableId<Pose> a, VariableId<Pose> b, VariableId<Scalar>,
                   const Pose& z) {
    g.join(Between<SE2d>{z, Eigen::Vector3d(2500, 2500, 1e4).asDiagonal()}, a, b);
  }
  static void see(Both<Graph>& g, VariableId<Pose> a, VariableId<Point> l, VariableId<Scalar>,
                  const Point& z) {
    g.join(Robust{BearingRange{Angle::radians(std::atan2(z.y(), z.x())), z.norm(),
                               Eigen::Vector2d(2500, 400).asDiagonal()},
                  RobustKernel{RobustKernelKind::huber, 3.0}},
           a, l);
  }
};

/// Odometry whose scale is estimated: three variables, dual numbers.
struct ScaledStep {
  using Variables = EdgeVariables<SE2d, SE2d, Scalar>;
  using Jacobians = AutomaticJacobians;
  static constexpr int kDim = 3;
  Eigen::Vector3d step;

  template <class T>
  Eigen::Matrix<T, 3, 1> error(const SE2<T>& from, const SE2<T>& to,
                               const Eigen::Matrix<T, 1, 1>& scale) const {
    const SE2<T> d = from.inverse() * to;
    return Eigen::Matrix<T, 3, 1>(d.x() - scale[0] * T(step[0]), d.y() - scale[0] * T(step[1]),
                                  d.heading().radians() - T(step[2])) /
           T(0.02);
  }
};

/// Without Jacobians: differences.
struct Sighting {
  using Variables = EdgeVariables<SE2d, Eigen::Vector2d>;
  static constexpr int kDim = 2;
  Eigen::Vector2d seen;
  Eigen::Vector2d error(const SE2d& x, const Eigen::Vector2d& l) const {
    return (x.inverse() * l - seen) / 0.05;
  }
};

struct ScaledWheels {
  using Pose = SE2d;
  using Point = Eigen::Vector2d;
  static constexpr bool kScaled = true;
  using Graph = FactorGraph<Variables<SE2d, Point, Scalar>,
                            Edges<ScaledStep, Sighting, Prior<Scalar>, RangeTo<SE2d>>>;

  static void move(Both<Graph>& g, VariableId<Pose> a, VariableId<Pose> b, VariableId<Scalar> s,
                   const Pose& z) {
    g.join(ScaledStep{{z.x(), z.y(), z.heading().radians()}}, a, b, s);
  }
  static void see(Both<Graph>& g, VariableId<Pose> a, VariableId<Point> l, VariableId<Scalar>,
                  const Point& z) {
    g.join(Sighting{z}, a, l);
    g.join(RangeTo<SE2d>{z.norm(), 100.0 * Scalar::Identity()}, a, l);
  }
};

/// A point seen by a sensor of unknown scale: 6, 3 and 1 numbers.
struct ScaledSight {
  using Variables = EdgeVariables<Scalar, SE3d, Eigen::Vector3d>;
  using Jacobians = AutomaticJacobians;
  static constexpr int kDim = 3;
  Eigen::Vector3d seen;

  template <class T>
  Eigen::Matrix<T, 3, 1> error(const Eigen::Matrix<T, 1, 1>& scale, const SE3<T>& x,
                               const Eigen::Matrix<T, 3, 1>& l) const {
    return (scale[0] * (x.inverse() * l) - seen.template cast<T>()) / T(0.05);
  }
};

struct Space {
  using Pose = SE3d;
  using Point = Eigen::Vector3d;
  static constexpr bool kScaled = true;
  using Graph =
      FactorGraph<Variables<Point, SE3d, Scalar>, Edges<Between<SE3d>, ScaledSight, Prior<Scalar>>>;

  static void move(Both<Graph>& g, VariableId<Pose> a, VariableId<Pose> b, VariableId<Scalar>,
                   const Pose& z) {
    g.join(Between<SE3d>{z, 2500.0 * Eigen::Matrix<double, 6, 6>::Identity()}, a, b);
  }
  static void see(Both<Graph>& g, VariableId<Pose> a, VariableId<Point> l, VariableId<Scalar> s,
                  const Point& z) {
    g.join(ScaledSight{z}, s, a, l);
  }
};

/// A walk in circles of radius 4 m about the origin's left, among twelve points.
template <class Kind>
class Walk {
 public:
  using Graph = typename Kind::Graph;
  using Pose = typename Kind::Pose;
  using Point = typename Kind::Point;

  explicit Walk(std::uint64_t seed) : rng_(seed) {
    for (int i = 0; i < 12; ++i) {
      Point p = Point::Zero();
      for (auto& v : p) v = rng_.uniform(-6.0, 6.0);
      p.y() += 4.0;
      places_.push_back(p);
    }
    points_.resize(places_.size());
  }

  /// The next pose, with odometry, and up to two points that it sees.
  void grow(Both<Graph>& g) {
    if (poses_.empty()) {
      truth_.assign(1, Pose());
      poses_.push_back(g.add(Pose(), true));
      if constexpr (Kind::kScaled) {
        scale_ = g.add(Scalar(1.0));
        g.join(Prior<Scalar>{Scalar(1.0), 25.0 * Scalar::Identity()}, scale_);
      }
    } else {
      TangentOf<Pose> step = TangentOf<Pose>::Zero();
      step[0] = 1.0;
      step[Pose::kDof - 1] = 0.25;
      truth_.push_back(truth_.back() * Pose::exp(step));
      const Pose measured = Pose::exp(step).plus(noise<Pose>(0.01));
      const auto last = poses_.back();
      poses_.push_back(g.add(g.tested[last] * measured));
      Kind::move(g, last, poses_.back(), scale_, measured);
    }
    for (int i = 0; i < 2; ++i) see(g, poses_.size() - 1, rng_.below(places_.size()));
  }

  void see(Both<Graph>& g, std::size_t pose, std::size_t place) {
    const Point seen = Point(truth_[pose].inverse() * places_[place]) + noise<Point>(0.05);
    VariableId<Point>& point = points_[place];
    if (point.index < 0) point = g.add(Point(g.tested[poses_[pose]] * seen));
    Kind::see(g, poses_[pose], point, scale_, seen);
  }
  /// Between a pose and a point that exist, or of a new one.
  void see_any(Both<Graph>& g) {
    if (!poses_.empty()) see(g, rng_.below(poses_.size()), rng_.below(places_.size()));
  }

  /// Variables from `size` on are gone.
  void forget(int size) {
    while (!poses_.empty() && poses_.back().index >= size) poses_.pop_back(), truth_.pop_back();
    for (auto& point : points_)
      if (point.index >= size) point = {};
    if (scale_.index >= size) scale_ = {};
  }

  [[nodiscard]] const std::vector<VariableId<Pose>>& poses() const { return poses_; }
  [[nodiscard]] const std::vector<VariableId<Point>>& points() const { return points_; }
  Rng& rng() { return rng_; }

 private:
  template <class X>
  TangentOf<X> noise(double sigma) {
    TangentOf<X> d;
    for (auto& v : d) v = sigma * rng_.normal();
    return d;
  }

  Rng rng_;
  std::vector<Pose> truth_;
  std::vector<VariableId<Pose>> poses_;
  std::vector<Point> places_;
  std::vector<VariableId<Point>> points_;
  VariableId<Scalar> scale_;
};

/// With zero thresholds every update is a step of the batch optimiser.
constexpr IncrementalOptions kStep{.relinearise_step = 0.0, .solve_change = 0.0, .max_rounds = 1};
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

using testing::same;

/// The largest difference of a variable.
template <class... V, class E>
double apart(const FactorGraph<Variables<V...>, E>& a, const FactorGraph<Variables<V...>, E>& b) {
  double most = a.size() == b.size() ? 0.0 : 1e300;
  const auto compare = [&]<class X>(std::type_identity<X>) {
    for (std::size_t i = 0; i < a.template all<X>().size(); ++i)
      most = std::max(most, ManifoldTraits<X>::minus(a.template all<X>()[i], b.template all<X>()[i])
                                .cwiseAbs()
                                .maxCoeff());
  };
  (compare(std::type_identity<V>{}), ...);
  return most;
}

/// Σ ρ of all edges, from their errors.
double cost_of(const auto& graph) {
  double sum = 0.0;
  graph.each_edge([&](const auto& edge, const auto&, const auto&... x) {
    sum += robust_value(edge, squared_error(edge, x...)).cost;
  });
  return sum;
}

}  // namespace wayfare::tests
