// Optimises the graph of a g2o file or of a landmark log and writes it as g2o.

#include <cstdio>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#ifdef WAYFARE_EXAMPLE_HAS_CHOLMOD
#include <wayfare/graph/cholmod_solver.hpp>
#endif
#include <wayfare/graph/eigen_solver.hpp>
#include <wayfare/graph/gnc.hpp>
#include <wayfare/graph/incremental.hpp>
#include <wayfare/graph/optimise.hpp>
#include <wayfare/io/landmark_graph.hpp>

#include "options.hpp"
#include "outputs.hpp"
#include "support/program_files.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

struct Outcome {
  OptimiseReport report;
  double start_s = 0.0;
  double total_s = 0.0;       ///< of the optimisation
  int rounds = 0;             ///< of graduated non-convexity
  std::vector<int> rejected;  ///< outlier edges
};

template <LieGroup G>
Result<OptimiseReport> optimise_with(PoseGraph<G>& graph, const Arguments& a) {
  switch (a.solver) {
    case SolverChoice::eigen:
      return PoseGraphOptimiser<G, EigenSolver<G::kDof>>().optimise(graph, a.options);
    case SolverChoice::cholmod:
#ifdef WAYFARE_EXAMPLE_HAS_CHOLMOD
      return PoseGraphOptimiser<G, CholmodSolver<G::kDof>>().optimise(graph, a.options);
#endif
    case SolverChoice::block:
      break;
  }
  return PoseGraphOptimiser<G>().optimise(graph, a.options);
}

template <class Graph>
Result<void> reject_outliers(Graph& graph, const Arguments& a, Outcome& outcome) {
  if (a.solver != SolverChoice::block)
    return Error{ErrorCode::unsupported, "--robust gnc uses the block solver only"};
  GncOptions options;
  options.loss = *a.gnc;
  options.inlier_probability = a.inlier_probability;
  options.start_from_trusted = a.start_from_trusted;
  options.optimise = a.options;
  auto report = optimise_gnc(graph, options);
  if (!report) return report.error();
  outcome.report = std::move(report->optimisation);
  outcome.rejected = std::move(report->rejected);
  outcome.rounds = report->rounds;
  return {};
}

/// Adds edge by edge and solves the graph after each.
template <LieGroup G>
Result<void> replay(PoseGraph<G>& graph, const Arguments& a, Outcome& outcome) {
  if (a.gnc || a.solver != SolverChoice::block)
    return Error{ErrorCode::unsupported,
                 "--incremental needs a kernel or none, and the block solver"};
  for (const int pose : graph.fixed) {
    if (pose == 0) continue;
    return Error{ErrorCode::unsupported, "--incremental fixes the first vertex only; vertex " +
                                             graph.label(pose) + " is fixed in the file"};
  }
  OptimiseReport& report = outcome.report;
  report.initial_chi2 = chi2(graph);
  report.initial_cost = robust_cost(graph, a.options.kernel);
  IncrementalOptimiser<G> optimiser(a.options.kernel);
  if (auto added = optimiser.add_pose(graph.poses.front()); !added) return added.error();
  for (const ReplayStep<G>& step : replay_steps(graph)) {
    if (step.new_pose >= 0) {
      if (auto added = optimiser.add_pose(step.placed(optimiser.poses())); !added)
        return added.error();
    }
    if (auto added = optimiser.add_edge(step.edge); !added) return added;
    const auto update = optimiser.update();
    if (!update) return update.error();
    report.iterations += update->rounds;
    report.fell_back = report.fell_back || update->fell_back;
  }
  if (optimiser.poses().size() != graph.poses.size())
    return Error{ErrorCode::degenerate,
                 "the edges do not connect every vertex in the order of the file"};
  graph.poses = optimiser.poses();
  report.final_chi2 = chi2(graph);
  report.final_cost = robust_cost(graph, a.options.kernel);
  return {};
}

/// Initialises the poses by --init, stores them in `initial` and optimises them.
template <LieGroup G>
Result<Outcome> solve(PoseGraph<G>& graph, const Arguments& a, std::vector<G>& initial) {
  Outcome outcome;
  const auto timed = [](double& seconds, const auto& work) -> Result<void> {
    const PhaseTimer timer(seconds);
    return work();
  };
  auto done = timed(outcome.start_s, [&] { return start_from(graph, a.start); });
  if (!done) return done.error();
  initial = graph.poses;
  done = timed(outcome.total_s, [&]() -> Result<void> {
    if (a.incremental) return replay(graph, a, outcome);
    if (a.gnc) return reject_outliers(graph, a, outcome);
    auto report = optimise_with(graph, a);
    if (!report) return report.error();
    outcome.report = std::move(*report);
    return {};
  });
  if (!done) return done.error();
  return outcome;
}

void print(const Outcome& outcome, const Arguments& a) {
  const OptimiseReport& r = outcome.report;
  if (a.start != StartMethod::given) std::printf("start      %.1f ms\n", 1e3 * outcome.start_s);
  if (a.gnc) {
    std::printf("rounds     %d\nrejected   %zu edges\n", outcome.rounds, outcome.rejected.size());
    std::printf("without rejected edges:\n");
  }
  std::printf("before     %.8g\n", r.initial_chi2);
  std::printf("after      %.8g\n", r.final_chi2);
  if (r.final_cost != r.final_chi2) {
    std::printf("robust     %.8g before, %.8g after\n", r.initial_cost, r.final_cost);
  }
  const std::string reason(a.incremental ? "edge by edge" : to_string(r.reason));
  std::printf("iterations %d (%s%s)\n", r.iterations, reason.c_str(),
              r.fell_back ? ", fell back to Levenberg-Marquardt" : "");
  const PhaseTimes& t = r.times;
  std::printf("time       %.1f ms", 1e3 * outcome.total_s);
  if (!a.gnc && !a.incremental) {
    std::printf(" (check %.1f, analyse %.1f, linearise %.1f, factorise %.1f, solve %.1f)",
                1e3 * t.validate_s, 1e3 * t.analyse_s, 1e3 * t.linearise_s, 1e3 * t.factorise_s,
                1e3 * t.solve_s);
  }
  std::printf("\n");
}

template <LieGroup G>
Result<void> write(const io::GraphFile<G>& file, const PoseGraph<G>& graph,
                   const std::vector<G>& initial, const Outcome& outcome, const Arguments& a) {
  const io::WriteOptions options = a.write();
  auto done = io::write_g2o(a.out, file, options);
  if (done && !a.svg.empty())
    done = io::write_file(a.svg, draw(graph, initial, outcome.rejected), options);
  if (done && !a.rejected.empty())
    done = io::write_file(a.rejected, edges_table(graph, outcome.rejected), options);
  if (!done || a.marginals.empty()) return done;
  const auto table = marginals_table(graph, outcome.rejected, a.options.kernel);
  return table ? io::write_file(a.marginals, *table, options) : table.error();
}

bool is_robust(const Arguments& a) {
  return a.gnc || a.options.kernel.kind != RobustKernelKind::none;
}

/// What graphs with landmarks or priors do not support.
Result<void> check_landmark_options(const Arguments& a) {
  const bool starts = a.start != StartMethod::given || a.incremental;
  if (starts || a.solver != SolverChoice::block || !a.rejected.empty())
    return Error{
        ErrorCode::unsupported,
        "--incremental, --init, --solver and --rejected are for graphs of poses alone; the "
        "file has landmarks or priors",
        a.input};
  if (is_robust(a) && !a.marginals.empty())
    return Error{ErrorCode::unsupported,
                 "--marginals of landmarks trust all edges: not with --robust", a.input};
  return {};
}

/// Optimises a file with landmarks from its values.
template <LieGroup G>
Result<Outcome> solve_landmarks(io::GraphFile<G>& file, const Arguments& a) {
  Outcome outcome;
  const auto solve = [&](auto& graph) -> Result<void> {
    auto report = optimise(graph, a.options);
    if (!report) return report.error();
    outcome.report = std::move(*report);
    return {};
  };
  const auto take = [&](auto graph, const auto& work) -> Result<Outcome> {
    auto done = Result<void>{};
    {
      const PhaseTimer timer(outcome.total_s);
      done = work(graph);
    }
    if (!done) return done.error();
    io::take_values(graph, file);
    return outcome;
  };
  if (!is_robust(a)) return take(io::to_factor_graph(file), solve);
  return take(
      io::to_robust_factor_graph(file, a.options.kernel, a.robust_odometry),
      [&](auto& graph) { return a.gnc ? reject_outliers(graph, a, outcome) : solve(graph); });
}

template <LieGroup G>
Result<void> run_landmarks(io::GraphFile<G>& file, const Arguments& a) {
  if (auto ok = check_landmark_options(a); !ok) return ok;
  const io::GraphFile<G> start = file;
  std::printf("vertices   %zu\nlandmarks  %zu\nedges      %d\n", file.vertices.size(),
              file.landmarks.size(), io::to_factor_graph(file).edge_count());
  const auto outcome = solve_landmarks(file, a);
  if (!outcome) return outcome.error();
  print(*outcome, a);
  auto done = io::write_g2o(a.out, file, a.write());
  if (done && !a.svg.empty()) done = io::write_file(a.svg, draw(start, file), a.write());
  if (!done || a.marginals.empty()) return done;
  const auto table = marginals_table(file);
  return table ? io::write_file(a.marginals, *table, a.write()) : table.error();
}

template <LieGroup G>
Result<void> run(io::GraphFile<G>& file, const Arguments& a) {
  for (const auto& [kind, lines] : file.ignored)
    std::fprintf(stderr, "pose_graph: %zu lines of unknown kind %s ignored\n", lines, kind.c_str());
  if (auto ok = a.grow ? io::start_from_growth(file) : Result<void>{}; !ok) return ok;
  if (!file.only_poses()) return run_landmarks(file, a);
  PoseGraph<G> graph = io::to_pose_graph(file);
  if (a.robust_odometry)
    for (auto& edge : graph.edges) edge.robust = true;
  std::printf("vertices   %zu\nedges      %zu\n", graph.poses.size(), graph.edges.size());
  std::vector<G> initial;
  const auto outcome = solve(graph, a, initial);
  if (!outcome) return outcome.error();
  print(*outcome, a);
  io::take_poses(graph, file);
  return write(file, graph, initial, *outcome, a);
}

Result<void> run(const Arguments& a) {
  if (auto ok = refuse_existing({a.out, a.svg, a.marginals, a.rejected}, a.write()); !ok) return ok;
  auto file = io::read_g2o(a.input, a.file);
  if (!file) return file.error();
  return std::visit([&](auto& graph) { return run(graph, a); }, *file);
}

}  // namespace

int main(int argc, char** argv) {
  Arguments arguments;
  if (const auto code = parse(argc, argv, arguments)) return *code;
  return exit_code("pose_graph", run(arguments));
}
