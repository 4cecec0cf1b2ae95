// Optimises the graph of a g2o file or of a landmark log and writes it as g2o.

#include <cstdio>
#include <string>
#include <variant>
#include <vector>

#include <wayfare/graph/incremental.hpp>
#include <wayfare/io/landmark_graph.hpp>

#include "options.hpp"
#include "outputs.hpp"
#include "solve.hpp"
#include "support/program_files.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

/// Adds edge by edge and solves the graph after each.
template <LieGroup G>
Result<void> replay(PoseGraph<G>& graph, const Arguments& a, Outcome& outcome) {
  if (a.rejects() || a.solver != SolverChoice::block)
    return bad_use("--incremental needs a kernel or none, and the block solver");
  for (const int pose : graph.fixed) {
    if (pose == 0) continue;
    return Error{ErrorCode::unsupported, "--incremental fixes the first vertex only; vertex " +
                                             graph.label(pose) + " is fixed in the file"};
  }
  outcome.steps = "edge by edge";
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
  auto done = timed(outcome.start_s, [&] { return start_from(graph, a.start); });
  if (!done) return done.error();
  initial = graph.poses;
  done = timed(outcome.total_s, [&]() -> Result<void> {
    if (a.incremental) return replay(graph, a, outcome);
    if (a.cycles) return reject_false_loops(graph, a, outcome);
    return a.gnc ? reject_outliers(graph, a, outcome) : optimise_by(graph, a, outcome);
  });
  if (!done) return done.error();
  return outcome;
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

template <LieGroup G>
Result<Doubt> run(io::GraphFile<G>& file, const Arguments& a) {
  for (const auto& [kind, lines] : file.ignored)
    std::fprintf(stderr, "pose_graph: %zu lines of unknown kind %s ignored\n", lines, kind.c_str());
  if (auto ok = a.grow ? io::start_from_growth(file) : Result<void>{}; !ok) return ok.error();
  if (!file.only_poses()) return run_landmarks(file, a);
  PoseGraph<G> graph = io::to_pose_graph(file);
  if (a.robust_odometry)
    for (auto& edge : graph.edges) edge.robust = true;
  if (!a.quiet)
    std::printf("vertices   %zu\nedges      %zu\n", graph.poses.size(), graph.edges.size());
  std::vector<G> initial;
  const auto outcome = solve(graph, a, initial);
  if (!outcome) return outcome.error();
  if (!a.quiet) print(*outcome, a);
  io::take_poses(graph, file);
  if (auto done = write(file, graph, initial, *outcome, a); !done) return done.error();
  return finish(graph.poses.size(), graph.edges.size(), *outcome, a);
}

Result<Doubt> run(const Arguments& a) {
  if (auto ok = check_writable({a.out, a.svg, a.marginals, a.rejected}, a.write()); !ok)
    return ok.error();
  if (auto ok = a.prepare_json(); !ok) return ok.error();
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
