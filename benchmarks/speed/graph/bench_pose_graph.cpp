// Complete optimisations of public graphs from the files' poses, with wayfare and Ceres: one
// thread, the same error and Jacobians, the same termination (relative gain below 1e-6). The
// counter `chi2` is the final value. Also, at the file's poses and with allocated memory:
// GRAPH_system, factorising H and solving once; GRAPH_linearise; GRAPH_marginals, the covariances
// of all poses from a factorised H, and GRAPH_factorise to compare with. With two threads, wall
// time.

#include <array>
#include <filesystem>
#include <string>

#include <benchmark/benchmark.h>
#include <ceres/ceres.h>

#include <wayfare/graph/eigen_solver.hpp>
#include <wayfare/graph/optimise.hpp>
#include <wayfare/io/g2o.hpp>
#ifdef WAYFARE_BENCH_CHOLMOD
#include <wayfare/graph/cholmod_solver.hpp>
#endif

namespace {

using namespace wayfare;

/// The group element is stored, with our tangent in Ceres: a perturbation of the initial pose would
/// fail for large rotations.
template <class G>
struct Stored;

template <>
struct Stored<SE2d> {
  static constexpr int kSize = 4;  // x, y, cos, sin
  static void store(const SE2d& x, double* p) {
    p[0] = x.x(), p[1] = x.y(), p[2] = x.rotation().cos(), p[3] = x.rotation().sin();
  }
  static SE2d load(const double* p) {
    return {Eigen::Vector2d(p[0], p[1]), SO2d::from_unit_complex(p[2], p[3])};
  }
};

template <>
struct Stored<SE3d> {
  static constexpr int kSize = 7;  // translation, quaternion (x, y, z, w)
  static void store(const SE3d& x, double* p) {
    Eigen::Map<Eigen::Vector3d>{p} = x.translation();
    Eigen::Map<Eigen::Vector4d>{p + 3} = x.rotation().quaternion().coeffs();
  }
  static SE3d load(const double* p) {
    return {Eigen::Map<const Eigen::Vector3d>(p), SO3d(Eigen::Quaterniond(p + 3))};
  }
};

/// The Jacobian of plus is [I; 0], so the first kDof columns of the cost are those of the tangent:
/// the parameterisation costs Ceres nothing.
template <class G>
class TangentManifold : public ceres::Manifold {
 public:
  int AmbientSize() const override { return Stored<G>::kSize; }
  int TangentSize() const override { return G::kDof; }
  bool Plus(const double* x, const double* delta, double* y) const override {
    const Eigen::Map<const typename G::Tangent> tau(delta);
    Stored<G>::store(Stored<G>::load(x).plus(tau), y);
    return true;
  }
  bool PlusJacobian(const double*, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, Stored<G>::kSize, G::kDof, Eigen::RowMajor>>{jacobian}
        .setIdentity();
    return true;
  }
  bool Minus(const double* y, const double* x, double* delta) const override {
    Eigen::Map<typename G::Tangent>{delta} = Stored<G>::load(y).minus(Stored<G>::load(x));
    return true;
  }
  bool MinusJacobian(const double*, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, G::kDof, Stored<G>::kSize, Eigen::RowMajor>>{jacobian}
        .setIdentity();
    return true;
  }
};

template <class G>
class EdgeCost : public ceres::SizedCostFunction<G::kDof, Stored<G>::kSize, Stored<G>::kSize> {
 public:
  explicit EdgeCost(const PoseEdge<G>& edge)
      : measurement_(edge.measurement), root_(edge.information.llt().matrixU()) {}

  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    const G from = Stored<G>::load(x[0]), to = Stored<G>::load(x[1]);
    Eigen::Map<typename G::Tangent> r(residuals);
    if (jacobians == nullptr) {
      r.noalias() = root_ * PoseError<G>::error(measurement_, from, to);
      return true;
    }
    const auto l = PoseError<G>::linearise(measurement_, from, to);
    r.noalias() = root_ * l.error;
    write(jacobians[0], l.by_from);
    write(jacobians[1], l.by_to);
    return true;
  }

 private:
  void write(double* out, const SquareOf<G>& jacobian) const {
    if (out == nullptr) return;
    Eigen::Map<Eigen::Matrix<double, G::kDof, Stored<G>::kSize, Eigen::RowMajor>> j(out);
    j.setZero();
    j.template leftCols<G::kDof>().noalias() = root_ * jacobian;
  }

  G measurement_;
  SquareOf<G> root_;
};

template <class G>
double solve_with_ceres(const PoseGraph<G>& graph) {
  std::vector<std::array<double, Stored<G>::kSize>> x(graph.poses.size());
  ceres::Problem problem;
  for (std::size_t i = 0; i < x.size(); ++i) {
    Stored<G>::store(graph.poses[i], x[i].data());
    problem.AddParameterBlock(x[i].data(), Stored<G>::kSize, new TangentManifold<G>);
  }
  problem.SetParameterBlockConstant(x[0].data());
  for (const auto& e : graph.edges) {
    problem.AddResidualBlock(new EdgeCost<G>(e), nullptr,
                             x[static_cast<std::size_t>(e.from)].data(),
                             x[static_cast<std::size_t>(e.to)].data());
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
  options.function_tolerance = 1e-6;
  options.max_num_iterations = 100;
  options.num_threads = 1;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  return 2.0 * summary.final_cost;
}

/// Repeats work(equations) on a linearised graph.
template <class Work>
void run_kept(benchmark::State& state, const std::string& name, const Work& work) {
  const std::string path = std::string(WAYFARE_DATA_DIR) + "/posegraph/" + name + ".g2o.gz";
  const auto file = io::read_g2o(path);
  if (!file) return state.SkipWithError(file.error().to_string().c_str());
  std::visit(
      [&](const auto& any) {
        const auto graph = io::to_pose_graph(any);
        using G = typename std::remove_cvref_t<decltype(graph.poses)>::value_type;
        NormalEquations<G> equations;
        equations.set_structure(graph);
        equations.linearise(graph, {});
        work(state, graph, equations);
      },
      *file);
}

template <template <int> class Solver>
void solve_system(benchmark::State& state, const auto&, auto& equations, int threads = 1) {
  constexpr int kDof = std::remove_cvref_t<decltype(equations)>::kDof;
  Solver<kDof> solver;
  if constexpr (ThreadedSolver<Solver<kDof>>) solver.set_threads(threads);
  solver.analyse(equations.hessian());
  solver.factorise(equations.hessian());
  for (auto _ : state) {
    Eigen::VectorXd step = -equations.gradient();
    solver.factorise(equations.hessian());
    solver.solve_in_place(step);
    benchmark::DoNotOptimize(step.data());
  }
}

template <bool kInvert>
void factorise_or_invert(benchmark::State& state, const auto&, auto& equations, int threads = 1) {
  constexpr int kDof = std::remove_cvref_t<decltype(equations)>::kDof;
  MultifrontalCholesky<kDof> solver;
  solver.set_threads(threads);
  solver.analyse(equations.hessian());
  solver.factorise(equations.hessian());
  if constexpr (kInvert) solver.invert();  // memory taken, as for the factor
  std::vector<Eigen::Matrix<double, kDof, kDof>> all(equations.free().size());
  for (auto _ : state) {
    if constexpr (kInvert) {
      solver.invert();
      for (std::size_t c = 0; c < all.size(); ++c)
        solver.inverse_block(static_cast<int>(c), static_cast<int>(c), all[c]);
    } else {
      solver.factorise(equations.hessian());
    }
    benchmark::DoNotOptimize(all.data());
  }
}

void linearise(benchmark::State& state, const auto& graph, auto& equations) {
  for (auto _ : state) equations.linearise(graph, {});
}

template <class Solve>
void run(benchmark::State& state, const std::string& name, const Solve& solve) {
  const std::string path = std::string(WAYFARE_DATA_DIR) + "/posegraph/" + name + ".g2o.gz";
  const auto file = io::read_g2o(path);
  if (!file) return state.SkipWithError(file.error().to_string().c_str());
  std::visit(
      [&](const auto& any) {
        const auto start = io::to_pose_graph(any);
        double reached = 0.0;
        for (auto _ : state) reached = solve(start);
        state.counters["chi2"] = reached;
      },
      *file);
}

template <template <int> class Solver>
double solve_with(const auto& start, int threads = 1) {
  auto graph = start;
  using G = typename std::remove_cvref_t<decltype(graph.poses)>::value_type;
  const auto report =
      PoseGraphOptimiser<G, Solver<G::kDof>>().optimise(graph, {.threads = threads});
  return report ? report->final_chi2 : -1.0;
}

const bool kRegistered = [] {
  for (const std::string name :
       {"MIT", "intel", "M3500", "city10000", "parking-garage", "sphere2500"}) {
    const auto add_kept = [&](const std::string& what, auto work) {
      return benchmark::RegisterBenchmark((name + "_" + what).c_str(),
                                          [=](benchmark::State& s) { run_kept(s, name, work); })
          ->Unit(benchmark::kMillisecond);
    };
    using S = benchmark::State;
    add_kept("system/wayfare",
             [](S& s, const auto& g, auto& e) { solve_system<MultifrontalCholesky>(s, g, e); });
    add_kept("system/wayfare_two_threads", [](S& s, const auto& g, auto& e) {
      solve_system<MultifrontalCholesky>(s, g, e, 2);
    })->UseRealTime();
#ifdef WAYFARE_BENCH_CHOLMOD
    add_kept("system/wayfare_cholmod",
             [](S& s, const auto& g, auto& e) { solve_system<CholmodSolver>(s, g, e); });
#endif
    add_kept("linearise/wayfare", [](S& s, const auto& g, auto& e) { linearise(s, g, e); });
    add_kept("factorise/wayfare",
             [](S& s, const auto& g, auto& e) { factorise_or_invert<false>(s, g, e); });
    add_kept("factorise/wayfare_two_threads", [](S& s, const auto& g, auto& e) {
      factorise_or_invert<false>(s, g, e, 2);
    })->UseRealTime();
    add_kept("marginals/wayfare",
             [](S& s, const auto& g, auto& e) { factorise_or_invert<true>(s, g, e); });
    const auto add = [&](const std::string& who, auto solve) {
      return benchmark::RegisterBenchmark((name + "/" + who).c_str(),
                                          [=](benchmark::State& s) { run(s, name, solve); })
          ->Unit(benchmark::kMillisecond);
    };
    add("wayfare", [](const auto& g) { return solve_with<MultifrontalCholesky>(g); });
    add("wayfare_two_threads", [](const auto& g) {
      return solve_with<MultifrontalCholesky>(g, 2);
    })->UseRealTime();
    add("wayfare_eigen", [](const auto& g) { return solve_with<EigenSolver>(g); });
#ifdef WAYFARE_BENCH_CHOLMOD
    add("wayfare_cholmod", [](const auto& g) { return solve_with<CholmodSolver>(g); });
#endif
    add("ceres", [](const auto& g) { return solve_with_ceres(g); });
  }
  return true;
}();

}  // namespace
