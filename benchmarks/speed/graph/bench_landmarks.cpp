// Complete optimisations of factor graphs with landmarks, with wayfare and Ceres: one thread, the
// same start, errors, Jacobians and kernels, the same termination (relative gain below 1e-8). The
// counter `cost` is the final value, `inside_ms` the time of Ceres without setting up its problem.
//
// victoria_park: poses and trees of the optimum, moved by noise of 0.3 m and 1° (1 m for trees), as
// odometry alone starts both too far from it. plaza2: odometry, beacons where the circles of their
// first ranges meet, Cauchy kernels, the scale of the ranges free.

#include <array>
#include <cstddef>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include <benchmark/benchmark.h>
#include <ceres/ceres.h>

#include <wayfare/core/random.hpp>
#include <wayfare/graph/optimise.hpp>
#include <wayfare/io/landmark_graph.hpp>

#include "range_run.hpp"

namespace {

using namespace wayfare;

constexpr double kGain = 1e-8;

/// The numbers Ceres keeps of a variable: of vectors themselves, of SE2 a unit complex number, with
/// our tangent, so that the parameterisation costs Ceres nothing.
template <class V>
struct Stored {
  static constexpr int kSize = V::RowsAtCompileTime;
  static void store(const V& x, double* p) { Eigen::Map<V>{p} = x; }
  static V load(const double* p) { return Eigen::Map<const V>(p); }
};
template <>
struct Stored<SE2d> {
  static constexpr int kSize = 4;
  static void store(const SE2d& x, double* p) {
    p[0] = x.x(), p[1] = x.y(), p[2] = x.rotation().cos(), p[3] = x.rotation().sin();
  }
  static SE2d load(const double* p) {
    return {Eigen::Vector2d(p[0], p[1]), SO2d::from_unit_complex(p[2], p[3])};
  }
};

class PoseManifold : public ceres::Manifold {
 public:
  int AmbientSize() const override { return 4; }
  int TangentSize() const override { return 3; }
  bool Plus(const double* x, const double* delta, double* y) const override {
    Stored<SE2d>::store(Stored<SE2d>::load(x).plus(Eigen::Map<const Eigen::Vector3d>(delta)), y);
    return true;
  }
  bool PlusJacobian(const double*, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, 4, 3, Eigen::RowMajor>>{jacobian}.setIdentity();
    return true;
  }
  bool Minus(const double* y, const double* x, double* delta) const override {
    Eigen::Map<Eigen::Vector3d>{delta} = Stored<SE2d>::load(y).minus(Stored<SE2d>::load(x));
    return true;
  }
  bool MinusJacobian(const double*, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>{jacobian}.setIdentity();
    return true;
  }
};

/// Any edge of ours.
template <class E, class Variables>
class EdgeCost;
template <class E, class... V>
class EdgeCost<E, EdgeVariables<V...>>
    : public ceres::SizedCostFunction<E::kDim, Stored<V>::kSize...> {
 public:
  explicit EdgeCost(const E& edge) : edge_(edge), root_(edge.information.llt().matrixU()) {}

  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    return evaluate(x, residuals, jacobians, std::index_sequence_for<V...>{});
  }

 private:
  template <std::size_t... I>
  bool evaluate(double const* const* x, double* residuals, double** jacobians,
                std::index_sequence<I...>) const {
    Eigen::Map<EdgeError<E>> r(residuals);
    if (jacobians == nullptr) {
      r = root_ * edge_.error(Stored<V>::load(x[I])...);
      return true;
    }
    JacobiansOf<E> j;
    r = root_ * linearise(edge_, j, Stored<V>::load(x[I])...);
    (write<V>(jacobians[I], std::get<I>(j.by)), ...);
    return true;
  }
  template <class X, class Jacobian>
  void write(double* out, const Jacobian& by) const {
    if (out == nullptr) return;
    constexpr int kSize = Stored<X>::kSize, kDof = ManifoldTraits<X>::kDof;
    constexpr auto kOrder = kSize == 1 ? Eigen::ColMajor : Eigen::RowMajor;
    Eigen::Map<Eigen::Matrix<double, E::kDim, kSize, kOrder>> j(out);
    if constexpr (kSize > kDof) j.setZero();
    j.template leftCols<kDof>() = root_ * by;
  }

  E edge_;
  Eigen::Matrix<double, E::kDim, E::kDim> root_;
};

struct Solved {
  double cost = -1.0;
  double inside_ms = 0.0;
};

/// The graph's variables in Ceres' memory, and its edges.
template <class Graph>
class CeresProblem {
 public:
  explicit CeresProblem(const Graph& graph) : numbers_(static_cast<std::size_t>(graph.size())) {
    graph.each_edge([&]<class E, class... X>(const E& edge, const auto& variables, const X&... x) {
      std::size_t i = 0;
      const std::vector<double*> blocks{block(variables[i++], x)...};
      ceres::LossFunction* loss = nullptr;
      if constexpr (requires { edge.kernel.scale; })
        loss = new ceres::CauchyLoss(edge.kernel.scale);
      problem_.AddResidualBlock(new EdgeCost<E, typename E::Variables>(edge), loss, blocks);
    });
    for (const int variable : graph.fixed())
      problem_.SetParameterBlockConstant(numbers_[static_cast<std::size_t>(variable)].data());
  }

  Solved solve(ceres::LinearSolverType type) {
    ceres::Solver::Options options;
    options.linear_solver_type = type;
    options.sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
    options.function_tolerance = kGain;
    options.max_num_iterations = 100;
    options.num_threads = 1;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem_, &summary);
    return {2.0 * summary.final_cost, 1e3 * summary.total_time_in_seconds};
  }

 private:
  template <class X>
  double* block(int variable, const X& x) {
    double* const p = numbers_[static_cast<std::size_t>(variable)].data();
    if (problem_.HasParameterBlock(p)) return p;
    Stored<X>::store(x, p);
    if constexpr (std::is_same_v<X, SE2d>)
      problem_.AddParameterBlock(p, Stored<X>::kSize, new PoseManifold);
    else
      problem_.AddParameterBlock(p, Stored<X>::kSize);
    return p;
  }

  std::vector<std::array<double, 4>> numbers_;
  ceres::Problem problem_;
};

template <class Graph>
Solved solve_with_wayfare(const Graph& start) {
  Graph graph = start;
  OptimiseOptions options;
  options.min_relative_gain = kGain;
  const auto report = optimise(graph, options);
  return report ? Solved{report->final_cost, 1e3 * report->times.total_s} : Solved{};
}

using ParkGraph =
    FactorGraph<Variables<SE2d, Eigen::Vector2d>, Edges<Between<SE2d>, LandmarkPosition<SE2d>>>;

/// Only with the types of edges it has.
Result<ParkGraph> victoria_park() {
  auto any = io::read_g2o(std::string(WAYFARE_DATA_DIR) + "/landmarks/victoria_park.txt.gz");
  if (!any) return any.error();
  auto& file = std::get<io::GraphFile<SE2d>>(*any);
  if (auto started = io::start_from_growth(file, 100); !started) return started.error();
  const auto grown = io::to_factor_graph(file);
  ParkGraph graph;
  Rng rng(1);
  for (const SE2d& pose : grown.all<SE2d>()) {
    const Eigen::Vector3d noise(0.3 * rng.normal(), 0.3 * rng.normal(), 0.0175 * rng.normal());
    graph.add(graph.size() == 0 ? pose : pose.plus(noise));
  }
  for (const Eigen::Vector2d& tree : grown.all<Eigen::Vector2d>())
    graph.add(Eigen::Vector2d(tree + Eigen::Vector2d(rng.normal(), rng.normal())));
  graph.fix(VariableId<SE2d>{0});
  for (const auto& [edge, ends] : grown.edges<Between<SE2d>>())
    graph.add(edge, VariableId<SE2d>{ends[0]}, VariableId<SE2d>{ends[1]});
  for (const auto& [edge, ends] : grown.edges<LandmarkPosition<SE2d>>())
    graph.add(edge, VariableId<SE2d>{ends[0]}, VariableId<Eigen::Vector2d>{ends[1]});
  return graph;
}

Result<examples::RangeGraph> plaza2() {
  const std::string folder = std::string(WAYFARE_DATA_DIR) + "/landmarks/Plaza2_";
  const auto run = examples::read_range_run(folder + "DR.txt.gz", folder + "TD.txt.gz");
  if (!run) return run.error();
  return examples::range_graph(*run, true);
}

template <class Start, class Solve>
void add(const std::string& name, const Start& start, const Solve& solve) {
  benchmark::RegisterBenchmark(name.c_str(), [=](benchmark::State& state) {
    static const auto graph = start();  // one per graph and solver
    if (!graph) return state.SkipWithError(graph.error().to_string().c_str());
    Solved solved;
    for (auto _ : state) solved = solve(*graph);
    state.counters["cost"] = solved.cost;
    state.counters["inside_ms"] = solved.inside_ms;
  })->Unit(benchmark::kMillisecond);
}

template <class Start>
void add_all(const std::string& name, const Start& start) {
  add(name + "/wayfare", start, [](const auto& graph) { return solve_with_wayfare(graph); });
  add(name + "/ceres_normal_cholesky", start,
      [](const auto& graph) { return CeresProblem(graph).solve(ceres::SPARSE_NORMAL_CHOLESKY); });
  add(name + "/ceres_schur", start,
      [](const auto& graph) { return CeresProblem(graph).solve(ceres::SPARSE_SCHUR); });
}

const bool kRegistered = [] {
  add_all("victoria_park", victoria_park);
  add_all("plaza2", plaza2);
  return true;
}();

}  // namespace
