// Our minimum degree beside Eigen's on public graphs: GRAPH_order, the ordering alone, with the
// factor's nonzeros (scalars, without those added by merging fronts) and the operations on the
// fronts as counters; GRAPH_factorise, one factorisation; GRAPH_solve, the whole optimisation from
// the file's poses, with χ² as counter. GRAPH_simplicial and GRAPH_cholmod: one factorisation by
// Eigen and by CHOLMOD in each order.

#include <algorithm>
#include <filesystem>
#include <memory>
#include <numeric>
#include <string>
#include <variant>
#include <vector>

#include <benchmark/benchmark.h>

#include <wayfare/graph/eigen_solver.hpp>
#include <wayfare/graph/optimise.hpp>
#include <wayfare/io/g2o.hpp>
#ifdef WAYFARE_BENCH_CHOLMOD
#include <wayfare/graph/cholmod_solver.hpp>
#endif

#include "graph/cholesky/factor.hpp"
#include "graph/cholesky/symbolic.hpp"

namespace {

using namespace wayfare;
using cholesky::UpperPattern;

struct Wayfare {
  static std::vector<int> order(const auto& h) {
    return cholesky::minimum_degree({h.starts(), h.rows()});
  }
};

struct Eigens {
  static std::vector<int> order(const auto& h) {
    return cholesky::inverse_order(minimum_degree_order(h));
  }
};

/// MultifrontalCholesky in either order.
template <int N, class Ordering>
struct OrderedFronts {
  static constexpr int kBlock = N;

  void analyse(const BlockSparse<N>& h) {
    factor = std::make_unique<cholesky::Factor>(
        cholesky::plan_fronts({h.starts(), h.rows()}, Ordering::order(h), N), kLeadingUnits<N>);
  }
  FactorOutcome factorise(const BlockSparse<N>& h) {
    return factor->factorise(h.blocks() > 0 ? h.data(0) : nullptr);
  }
  void solve_in_place(Eigen::VectorXd& x) { factor->solve_in_place(x.data()); }

  std::unique_ptr<cholesky::Factor> factor;
};

double nonzeros(const UpperPattern& pattern, const std::vector<int>& order, int block) {
  using namespace cholesky;
  const auto first = elimination_tree(renumbered(pattern, inverse_order(order)));
  std::vector<int> both;
  for (const int i : postorder(first)) both.push_back(order[static_cast<std::size_t>(i)]);
  const ColumnLists above = renumbered(pattern, inverse_order(both));
  const auto counts = column_counts(above, elimination_tree(above));
  const double below = std::accumulate(counts.begin(), counts.end(), 0.0) - pattern.columns();
  return below * block * block + pattern.columns() * block * (block + 1) / 2.0;
}

double operations(const cholesky::FrontPlan& plan) {
  double sum = 0.0;
  for (const auto& f : plan.fronts) {
    const double p = f.columns * plan.block, m = f.rows * plan.block;
    sum += p * p * p / 3.0 + p * p * m + p * m * m;
  }
  return sum;
}

template <class Ordering>
struct Order {
  static void run(benchmark::State& state, const auto&, auto& equations) {
    const auto& h = equations.hessian();
    constexpr int kBlock = std::remove_cvref_t<decltype(h)>::kBlock;
    const UpperPattern pattern{h.starts(), h.rows()};
    std::vector<int> order;
    for (auto _ : state) order = Ordering::order(h);
    state.counters["nonzeros"] = nonzeros(pattern, order, kBlock);
    state.counters["operations"] = operations(cholesky::plan_fronts(pattern, order, kBlock));
  }
};

template <class Ordering>
struct Factorise {
  static void run(benchmark::State& state, const auto&, auto& equations) {
    const auto& h = equations.hessian();
    OrderedFronts<std::remove_cvref_t<decltype(h)>::kBlock, Ordering> solver;
    solver.analyse(h);
    if (!solver.factorise(h).ok) return state.SkipWithError("not positive definite");
    for (auto _ : state) benchmark::DoNotOptimize(solver.factorise(h).ok);
  }
};

template <class Ordering>
struct Solve {
  static void run(benchmark::State& state, const auto& start, auto&) {
    using G = typename std::remove_cvref_t<decltype(start.poses)>::value_type;
    for (auto _ : state) {
      auto graph = start;
      PoseGraphOptimiser<G, OrderedFronts<G::kDof, Ordering>> optimiser;
      const auto report = optimiser.optimise(graph);
      if (!report) return state.SkipWithError(report.error().to_string().c_str());
      state.counters["chi2"] = report->final_chi2;
    }
  }
};

/// What ScalarSolver does with a decomposition, in either order.
template <class Ordering, template <class> class Decomposition>
struct Scalar {
  static void run(benchmark::State& state, const auto&, auto& equations) {
    const auto& h = equations.hessian();
    using Expansion = ScalarExpansion<std::remove_cvref_t<decltype(h)>::kBlock>;
    Expansion expansion;
    expansion.build(h, cholesky::inverse_order(Ordering::order(h)));
    expansion.fill(h);
    Decomposition<typename Expansion::Matrix> decomposition;
    decomposition.analyzePattern(expansion.matrix());
    for (auto _ : state) decomposition.factorize(expansion.matrix());
    if (decomposition.info() != Eigen::Success) state.SkipWithError("not positive definite");
  }
};

template <class Matrix>
using Simplicial = Eigen::SimplicialLLT<Matrix, Eigen::Upper, Eigen::NaturalOrdering<int>>;
template <class Ordering>
using BySimplicial = Scalar<Ordering, Simplicial>;
#ifdef WAYFARE_BENCH_CHOLMOD
template <class Ordering>
using ByCholmod = Scalar<Ordering, detail::OrderedCholmod>;
#endif

template <class Task>
void run(benchmark::State& state, const std::filesystem::path& path) {
  const auto file = io::read_g2o(path, {.indefinite = io::IndefiniteInformation::project});
  if (!file) return state.SkipWithError(file.error().to_string().c_str());
  std::visit(
      [&](const auto& any) {
        const auto graph = io::to_pose_graph(any);
        using G = typename std::remove_cvref_t<decltype(graph.poses)>::value_type;
        NormalEquations<G> equations;
        equations.set_structure(graph);
        equations.linearise(graph, {});
        Task::run(state, graph, equations);
      },
      *file);
}

template <template <class> class Task>
void add(const std::filesystem::path& path, const std::string& what) {
  const std::string name = path.stem().stem().string() + "_" + what;
  const auto one = [&]<class Ordering>(const char* who) {
    benchmark::RegisterBenchmark((name + who).c_str(), [=](benchmark::State& s) {
      run<Task<Ordering>>(s, path);
    })->Unit(benchmark::kMillisecond);
  };
  one.template operator()<Wayfare>("/wayfare");
  one.template operator()<Eigens>("/eigen");
}

const bool kRegistered = [] {
  std::error_code missing;
  std::vector<std::filesystem::path> paths;
  for (const auto& entry : std::filesystem::directory_iterator(
           std::filesystem::path(WAYFARE_DATA_DIR) / "posegraph", missing))
    paths.push_back(entry.path());
  std::sort(paths.begin(), paths.end());
  for (const auto& path : paths) {
    add<Order>(path, "order");
    add<Factorise>(path, "factorise");
    add<Solve>(path, "solve");
    add<BySimplicial>(path, "simplicial");
#ifdef WAYFARE_BENCH_CHOLMOD
    add<ByCholmod>(path, "cholmod");
#endif
  }
  return true;
}();

}  // namespace
