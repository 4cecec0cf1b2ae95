// Optimises the graph of a g2o file or of a landmark log and writes it as g2o.

#include <cstdio>
#include <map>
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
#include <wayfare/graph/report.hpp>
#include <wayfare/io/landmark_graph.hpp>

#include "outputs.hpp"
#include "support/program_files.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

enum class SolverChoice { block, eigen, cholmod };

struct Arguments : OutputArguments {
  std::string input;
  std::string svg, marginals, rejected;  ///< empty: not written
  io::G2oOptions file;
  StartMethod start = StartMethod::given;
  bool start_from_trusted = false;  ///< GNC's own initialisation, without --init
  SolverChoice solver = SolverChoice::block;
  std::optional<GncLoss> gnc;  ///< for graduated non-convexity
  bool robust_odometry = false;
  bool incremental = false;
  bool grow = false;
  double inlier_probability = GncOptions{}.inlier_probability;
  OptimiseOptions options;
};

const std::map<std::string, SolverChoice> kSolvers{
    {"block", SolverChoice::block},
    {"eigen", SolverChoice::eigen},
#ifdef WAYFARE_EXAMPLE_HAS_CHOLMOD
    {"cholmod", SolverChoice::cholmod},
#endif
};
const std::map<std::string, OptimiseMethod> kMethods{{"gn", OptimiseMethod::gauss_newton},
                                                     {"lm", OptimiseMethod::levenberg_marquardt}};
const std::map<std::string, io::IndefiniteInformation> kIndefinite{
    {"refuse", io::IndefiniteInformation::refuse}, {"project", io::IndefiniteInformation::project}};
const std::map<std::string, io::LogMatrix> kLogMatrices{{"covariance", io::LogMatrix::covariance},
                                                        {"information", io::LogMatrix::information},
                                                        {"root", io::LogMatrix::root_information}};
using MaybeStart = std::optional<StartMethod>;
const std::map<std::string, MaybeStart> kStarts{{"file", StartMethod::given},
                                                {"odometry", StartMethod::odometry},
                                                {"tree", StartMethod::tree},
                                                {"chordal", StartMethod::chordal}};
/// A kernel, or a loss of graduated non-convexity.
struct Robust {
  RobustKernelKind kernel = RobustKernelKind::none;
  std::optional<GncLoss> gnc = {};
};
const std::map<std::string, Robust> kRobust{
    {"none", {}},
    {"huber", {RobustKernelKind::huber}},
    {"cauchy", {RobustKernelKind::cauchy}},
    {"gm", {RobustKernelKind::geman_mcclure}},
    {"dcs", {RobustKernelKind::dynamic_covariance_scaling}},
    {"gnc", {RobustKernelKind::none, GncLoss::truncated_least_squares}},
    {"gnc-gm", {RobustKernelKind::none, GncLoss::geman_mcclure}}};

void add_file_options(CommandLine& app, Arguments& a) {
  app.add_option("file", a.input,
                 "g2o file, 2D or 3D, or a landmark log (ODOMETRY, LANDMARK, BR), plain or gzip")
      .required();
  add_out(app, a, "file for the optimised graph");
  app.add_flag("--force", a.force, "replace existing files");
  app.add_option(
      "--svg", a.svg,
      "file for a drawing of the graph before and after: path, loops, landmarks, rejected "
      "loops in red (3D from above)");
  app.add_option(
      "--marginals", a.marginals,
      "CSV of every pose's covariance in its own frame, and every landmark's; fixed ones "
      "are exact");
  app.add_option("--rejected", a.rejected, "CSV of the edges that --robust gnc rejects");
  app.add_choice("--indefinite", a.file.indefinite, kIndefinite,
                 "information matrices that are not positive semi-definite: refuse the file "
                 "(default) or project onto the nearest that is");
  app.add_choice("--log-matrix", a.file.log_matrix, kLogMatrices,
                 "what the matrices of ODOMETRY and LANDMARK lines are (default covariance)");
}

void add_solver_options(CommandLine& app, Arguments& a, MaybeStart& start, Robust& robust) {
  app.add_choice("--init", start, kStarts,
                 "initial poses: of the file, the chain of edges between neighbours, a spanning "
                 "tree of least depth, or chordal relaxation (default file; with --robust gnc a "
                 "tree over odometry)");
  app.add_flag("--grow", a.grow,
               "initial values from optimising the graph as it grows in the order of the file: for "
               "logs whose odometry drifts far");
  app.add_choice(
      "--robust", robust, kRobust,
      "against outliers among edges between vertices that are not neighbours in the file: "
      "a kernel, or gnc (graduated non-convexity with truncated least squares; gnc-gm: "
      "with Geman-McClure), which identifies them (default none)");
  app.add_flag("--robust-all", a.robust_odometry, "edges between neighbours may be outliers too");
  app.add_positive("--robust-scale", a.options.kernel.scale,
                   "scale of the kernel in standard deviations");
  app.add_number("--inliers", a.inlier_probability, 0.5, 1.0 - 1e-12,
                 "share of inliers gnc is to keep if the information matrices are consistent");
  app.add_flag("--incremental", a.incremental,
               "add the graph edge by edge and solve after each; each pose is initialised by its "
               "first edge");
  app.add_choice("--method", a.options.method, kMethods,
                 "gn: Gauss-Newton, falling back to lm where a step fails (default); lm: "
                 "Levenberg-Marquardt");
  app.add_choice("--solver", a.solver, kSolvers,
                 "sparse Cholesky (default block: that of wayfare)");
  app.add_number("--threads", a.options.threads, 1, 256,
                 "of the block solver; results do not depend on their number");
  app.add_number("--max-iterations", a.options.max_iterations, 1, 1'000'000,
                 "largest number of linear systems solved");
}

/// The exit code if the program is to end.
std::optional<int> parse(int argc, char** argv, Arguments& a) {
  CommandLine app(
      "Optimise the graph of a g2o file, of poses or of poses and landmarks: prints the sum of "
      "e'We "
      "before and after (g2o's error, no factor 1/2), iterations and milliseconds, and writes the "
      "graph. With landmarks or priors the start is that of the file, and all edges are trusted.");
  MaybeStart start;
  Robust robust;
  add_file_options(app, a);
  add_solver_options(app, a, start, robust);
  if (const auto code = app.parse(argc, argv)) return code;
  a.options.kernel.kind = robust.kernel;
  a.gnc = robust.gnc;
  a.start_from_trusted = a.gnc && !start;
  a.start = start.value_or(StartMethod::given);
  return {};
}

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

template <LieGroup G>
Result<void> reject_outliers(PoseGraph<G>& graph, const Arguments& a, Outcome& outcome) {
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

/// What graphs with landmarks or priors do not support.
Result<void> check_landmark_options(const Arguments& a) {
  if (a.options.kernel.kind == RobustKernelKind::none && !a.gnc && !a.incremental &&
      a.start == StartMethod::given && a.solver == SolverChoice::block && a.rejected.empty())
    return {};
  const char* const message =
      "--robust, --incremental, --init, --solver and --rejected are for graphs of poses alone; the "
      "file has landmarks or priors";
  return Error{ErrorCode::unsupported, message, a.input};
}

template <LieGroup G>
Result<void> run_landmarks(io::GraphFile<G>& file, const io::GraphFile<G>& as_read,
                           const Arguments& a) {
  if (auto ok = check_landmark_options(a); !ok) return ok;
  auto graph = io::to_factor_graph(file);
  std::printf("vertices   %zu\nlandmarks  %zu\nedges      %d\n", file.vertices.size(),
              file.landmarks.size(), graph.edge_count());
  const auto report = optimise(graph, a.options);
  if (!report) return report.error();
  print({*report, 0.0, report->times.total_s, 0, {}}, a);
  io::take_values(graph, file);
  auto done = io::write_g2o(a.out, file, a.write());
  if (done && !a.svg.empty()) done = io::write_file(a.svg, draw(as_read, file), a.write());
  if (!done || a.marginals.empty()) return done;
  const auto table = marginals_table(file);
  return table ? io::write_file(a.marginals, *table, a.write()) : table.error();
}

template <LieGroup G>
Result<void> run(io::GraphFile<G>& file, const Arguments& a) {
  for (const auto& [kind, lines] : file.ignored)
    std::fprintf(stderr, "pose_graph: %zu lines of unknown kind %s ignored\n", lines, kind.c_str());
  const io::GraphFile<G> as_read = file;
  if (auto ok = a.grow ? io::start_from_growth(file) : Result<void>{}; !ok) return ok;
  if (!file.only_poses()) return run_landmarks(file, as_read, a);
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
