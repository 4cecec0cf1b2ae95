// Optimises a pose graph from a g2o file and writes it back.

#include <cstdio>
#include <string>
#include <variant>

#include <wayfare/io/g2o.hpp>

#include "program.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

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

template <LieGroup G>
Result<void> run(io::GraphFile<G>& file, const Arguments& a) {
  PoseGraph<G> graph = io::to_pose_graph(file);
  if (a.robust_odometry) {
    for (auto& edge : graph.edges) edge.robust = true;
  }
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
  auto file = io::read_g2o(a.input, {.indefinite = a.indefinite});
  if (!file) return file.error();
  return std::visit([&](auto& graph) { return run(graph, a); }, *file);
}

}  // namespace

int main(int argc, char** argv) {
  Arguments arguments;
  if (const auto code = parse(argc, argv, arguments)) return *code;
  return exit_code("pose_graph", run(arguments));
}
