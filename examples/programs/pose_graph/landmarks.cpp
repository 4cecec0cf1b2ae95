// Files with landmarks or priors.

#include <cstdio>

#include <wayfare/io/growing_landmark_graph.hpp>

#include "outputs.hpp"
#include "solve.hpp"

namespace wayfare::examples {
namespace {

bool is_robust(const Arguments& a) {
  return a.gnc || a.options.kernel.kind != RobustKernelKind::none;
}

Result<void> check_options(const Arguments& a) {
  if (a.cycles) return bad_use("--robust cycles is for graphs of poses alone");
  if (a.incremental && (a.gnc || a.solver != SolverChoice::block))
    return bad_use("--incremental needs a kernel or none, and the block solver");
  if (is_robust(a) && !a.marginals.empty())
    return bad_use(a.input + ": --marginals of landmarks trust all edges: not with --robust");
  return {};
}

/// --init on the poses and the edges between them, then each landmark where it is seen first.
template <LieGroup G>
Result<void> start(io::GraphFile<G>& file, const Arguments& a) {
  if (a.start == StartMethod::given) return {};
  PoseGraph<G> poses = io::to_pose_graph(file);
  if (auto done = start_from(poses, a.start); !done) return done;
  io::take_poses(poses, file);
  io::place_landmarks(file);
  return {};
}

template <class Graph>
void measure(const Graph& graph, double& chi2, double& cost) {
  chi2 = cost = 0.0;
  graph.each_edge([&](const auto& edge, const auto&, const auto&... x) {
    const double s = squared_error(edge, x...);
    chi2 += s;
    cost += robust_value(edge, s).cost;
  });
}

template <LieGroup G>
io::RobustLandmarkGraph<G> graph_of(const io::GraphFile<G>& file, const Arguments& a) {
  return io::to_robust_factor_graph(file, a.options.kernel, a.robust_odometry);
}

template <LieGroup G>
Result<void> replay(io::GraphFile<G>& file, const Arguments& a, Outcome& outcome) {
  OptimiseReport& report = outcome.report;
  measure(graph_of(file, a), report.initial_chi2, report.initial_cost);
  Result<io::GrowthReport> grown = io::GrowthReport{};
  auto done = timed(outcome.total_s, [&]() -> Result<void> {
    grown = io::optimise_growing(file, a.options.kernel, a.robust_odometry);
    return grown ? Result<void>{} : grown.error();
  });
  if (!done) return done;
  measure(graph_of(file, a), report.final_chi2, report.final_cost);
  report.iterations = grown->rounds;
  report.fell_back = grown->fell_back;
  outcome.steps = "vertex by vertex";
  return {};
}

template <LieGroup G>
Result<void> solve(io::GraphFile<G>& file, const Arguments& a, Outcome& outcome) {
  if (a.incremental) return replay(file, a, outcome);
  auto graph = graph_of(file, a);
  auto done = timed(outcome.total_s, [&] {
    return a.gnc ? reject_outliers(graph, a, outcome) : optimise_by(graph, a, outcome);
  });
  if (done) io::take_values(graph, file);
  return done;
}

template <LieGroup G>
Result<Doubt> run(io::GraphFile<G>& file, const Arguments& a) {
  if (auto ok = check_options(a); !ok) return ok.error();
  Outcome outcome;
  auto done = timed(outcome.start_s, [&] { return start(file, a); });
  if (!done) return done.error();
  const io::GraphFile<G> before = file;
  const int edges = graph_of(file, a).edge_count();
  if (!a.quiet)
    std::printf("vertices   %zu\nlandmarks  %zu\nedges      %d\n", file.vertices.size(),
                file.landmarks.size(), edges);
  if (auto solved = solve(file, a, outcome); !solved) return solved.error();
  if (!a.quiet) print(outcome, a);
  done = io::write_g2o(a.out, file, a.write());
  if (done && !a.svg.empty())
    done = io::write_file(a.svg, draw(before, file, outcome.rejected), a.write());
  if (done && !a.rejected.empty())
    done = io::write_file(a.rejected, edges_table(file, outcome.rejected), a.write());
  if (done && !a.marginals.empty()) {
    const auto table = marginals_table(file);
    done = table ? io::write_file(a.marginals, *table, a.write()) : table.error();
  }
  if (!done) return done.error();
  return finish(file.vertices.size() + file.landmarks.size(), static_cast<std::size_t>(edges),
                outcome, a);
}

}  // namespace

Result<Doubt> run_landmarks(io::GraphFile<SE2d>& file, const Arguments& a) { return run(file, a); }
Result<Doubt> run_landmarks(io::GraphFile<SE3d>& file, const Arguments& a) { return run(file, a); }

}  // namespace wayfare::examples
