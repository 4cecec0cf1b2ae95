// Optimises a pose graph from a g2o file and writes it back.

#include <cstdio>
#include <filesystem>
#include <map>
#include <string>
#include <variant>

#include <CLI/CLI.hpp>

#include <wayfare/graph/eigen_solver.hpp>
#include <wayfare/graph/optimise.hpp>
#include <wayfare/graph/start.hpp>
#include <wayfare/io/pose_graph_file.hpp>
#ifdef WAYFARE_EXAMPLE_HAS_CHOLMOD
#include <wayfare/graph/cholmod_solver.hpp>
#endif

#include "exit_code.hpp"

namespace {

using namespace wayfare;

enum class SolverChoice { block, eigen, cholmod };

struct Arguments {
  std::string input;
  std::string output;
  bool force = false;
  io::IndefiniteInformation indefinite = io::IndefiniteInformation::refuse;
  StartMethod start = StartMethod::given;
  bool robust_odometry = false;
  SolverChoice solver = SolverChoice::block;
  OptimiseOptions options;
};

const std::map<std::string, SolverChoice> kSolvers{
    {"block", SolverChoice::block},
    {"eigen", SolverChoice::eigen},
#ifdef WAYFARE_EXAMPLE_HAS_CHOLMOD
    {"cholmod", SolverChoice::cholmod},
#endif
};
const std::map<std::string, io::IndefiniteInformation> kIndefinite{
    {"refuse", io::IndefiniteInformation::refuse}, {"project", io::IndefiniteInformation::project}};
const std::map<std::string, StartMethod> kStarts{{"file", StartMethod::given},
                                                 {"odometry", StartMethod::odometry},
                                                 {"tree", StartMethod::tree},
                                                 {"chordal", StartMethod::chordal}};
const std::map<std::string, OptimiseMethod> kMethods{{"gn", OptimiseMethod::gauss_newton},
                                                     {"lm", OptimiseMethod::levenberg_marquardt}};
const std::map<std::string, RobustKernelKind> kKernels{
    {"none", RobustKernelKind::none},
    {"huber", RobustKernelKind::huber},
    {"cauchy", RobustKernelKind::cauchy},
    {"geman-mcclure", RobustKernelKind::geman_mcclure},
    {"dcs", RobustKernelKind::dynamic_covariance_scaling}};

void describe(CLI::App& app, Arguments& a) {
  app.add_option("file", a.input, "g2o file, 2D or 3D, plain or gzip")->required();
  app.add_option("--out", a.output, "where the optimised graph is written")->required();
  app.add_flag("--force", a.force, "overwrite the output where it exists");
  app.add_option("--indefinite", a.indefinite,
                 "information matrices that are not positive semi-definite: refuse the file "
                 "(default) or project onto the nearest that is")
      ->transform(CLI::CheckedTransformer(kIndefinite));
  app.add_option("--init", a.start,
                 "poses to start from: the file's (default), the chain of edges between "
                 "neighbours, a spanning tree of least depth, or chordal relaxation")
      ->transform(CLI::CheckedTransformer(kStarts));
  app.add_option("--solver", a.solver, "sparse Cholesky (default block: our own)")
      ->transform(CLI::CheckedTransformer(kSolvers));
  app.add_option("--method", a.options.method,
                 "gn: Gauss-Newton, falling back to lm where a step fails (default); lm: "
                 "Levenberg-Marquardt")
      ->transform(CLI::CheckedTransformer(kMethods));
  app.add_option("--robust", a.options.kernel.kind,
                 "kernel for edges between vertices that are not neighbours in the file "
                 "(default none)")
      ->transform(CLI::CheckedTransformer(kKernels));
  app.add_option("--robust-scale", a.options.kernel.scale,
                 "residual in standard deviations where the kernel bends")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_flag("--robust-all", a.robust_odometry, "the kernel applies to every edge");
  app.add_option("--max-iterations", a.options.max_iterations, "linear systems solved at most")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
}

template <LieGroup G>
Result<OptimiseReport> optimise_with(PoseGraph<G>& graph, const Arguments& a) {
#ifdef WAYFARE_EXAMPLE_HAS_CHOLMOD
  if (a.solver == SolverChoice::cholmod) {
    return PoseGraphOptimiser<G, CholmodSolver<ManifoldTraits<G>::kDof>>().optimise(graph,
                                                                                    a.options);
  }
#endif
  if (a.solver == SolverChoice::eigen) {
    return PoseGraphOptimiser<G, EigenSolver<ManifoldTraits<G>::kDof>>().optimise(graph, a.options);
  }
  return PoseGraphOptimiser<G>().optimise(graph, a.options);
}

void print(const OptimiseReport& r) {
  const auto& t = r.times;
  std::printf("before     %.8g\n", r.initial_chi2);
  std::printf("after      %.8g\n", r.final_chi2);
  if (r.final_cost != r.final_chi2) {
    std::printf("robust     %.8g before, %.8g after\n", r.initial_cost, r.final_cost);
  }
  std::printf("iterations %d (%s%s)\n", r.iterations, std::string(to_string(r.reason)).c_str(),
              r.fell_back ? ", fell back to Levenberg-Marquardt" : "");
  std::printf(
      "time       %.1f ms (check %.1f, analyse %.1f, linearise %.1f, factorise %.1f, "
      "solve %.1f)\n",
      1e3 * t.total_s, 1e3 * t.validate_s, 1e3 * t.analyse_s, 1e3 * t.linearise_s,
      1e3 * t.factorise_s, 1e3 * t.solve_s);
}

template <LieGroup G>
Result<void> run(io::GraphFile<G>& file, const Arguments& a) {
  PoseGraph<G> graph = io::to_pose_graph(file);
  if (a.robust_odometry) {
    for (auto& edge : graph.edges) edge.robust = true;
  }
  std::printf("vertices   %zu\nedges      %zu\n", graph.poses.size(), graph.edges.size());
  double start_s = 0.0;
  {
    const PhaseTimer timer(start_s);
    if (auto done = start_from(graph, a.start); !done) return done;
  }
  if (a.start != StartMethod::given) std::printf("start      %.1f ms\n", 1e3 * start_s);
  const auto report = optimise_with(graph, a);
  if (!report) return report.error();
  print(*report);
  io::take_poses(graph, file);
  return io::write_g2o(a.output, file, {a.force ? io::Existing::replace : io::Existing::refuse});
}

Result<void> run(const Arguments& a) {
  if (!a.force && std::filesystem::exists(a.output)) {
    return Error{ErrorCode::io, "exists already; --force overwrites it", a.output};
  }
  auto file = io::read_g2o(a.input, {.indefinite = a.indefinite});
  if (!file) return file.error();
  return std::visit([&](auto& graph) { return run(graph, a); }, *file);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "Optimises the pose graph of a g2o file: prints the sum of e'We before and after (g2o's "
      "error, no factor 1/2), iterations and milliseconds, and writes the graph."};
  Arguments arguments;
  describe(app, arguments);
  CLI11_PARSE(app, argc, argv);
  return examples::exit_code("pose_graph", run(arguments));
}
