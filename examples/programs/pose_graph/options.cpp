#include "options.hpp"

#include <map>

namespace wayfare::examples {

namespace {

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
/// A kernel, a loss of graduated non-convexity, or the consistency of cycles.
struct Robust {
  RobustKernelKind kernel = RobustKernelKind::none;
  std::optional<GncLoss> gnc = {};
  bool cycles = false;
};
const std::map<std::string, Robust> kRobust{
    {"none", {}},
    {"huber", {RobustKernelKind::huber}},
    {"cauchy", {RobustKernelKind::cauchy}},
    {"gm", {RobustKernelKind::geman_mcclure}},
    {"dcs", {RobustKernelKind::dynamic_covariance_scaling}},
    {"gnc", {RobustKernelKind::none, GncLoss::truncated_least_squares}},
    {"gnc-gm", {RobustKernelKind::none, GncLoss::geman_mcclure}},
    {"cycles", {RobustKernelKind::none, {}, true}}};

void add_file_options(CommandLine& app, Arguments& a) {
  app.add_option("file", a.input,
                 "g2o file, 2D or 3D, or a landmark log (ODOMETRY, LANDMARK, BR), plain or gzip")
      .shown_as("FILE")
      .required();
  app.add_option("--out", a.out, "file for the optimised graph").shown_as("FILE").required();
  add_force_and_quiet(app, a);
  add_json(app, a);
  app.add_option(
         "--svg", a.svg,
         "file for a drawing of the graph before and after: path, loops, landmarks, rejected "
         "loops in red (3D from above)")
      .shown_as("FILE");
  app.add_option(
         "--marginals", a.marginals,
         "CSV of every pose's covariance in its own frame, and every landmark's; fixed ones "
         "are exact")
      .shown_as("FILE");
  app.add_option("--rejected", a.rejected, "CSV of the edges that --robust gnc or cycles rejects")
      .shown_as("FILE");
  app.add_choice("--indefinite", a.file.indefinite, kIndefinite,
                 "information matrices that are not positive semi-definite: refuse the file "
                 "(default) or project onto the nearest that is");
  app.add_choice("--log-matrix", a.file.log_matrix, kLogMatrices,
                 "what the matrices of ODOMETRY and LANDMARK lines are (default covariance)");
}

void add_solver_options(CommandLine& app, Arguments& a, MaybeStart& start, Robust& robust) {
  app.add_choice(
      "--init", start, kStarts,
      "initial poses: of the file, the chain of edges between neighbours, a spanning "
      "tree of least uncertainty, or chordal relaxation, along the edges between poses; landmarks "
      "then where they are first seen (default file; of poses alone with --robust gnc a "
      "tree over odometry)");
  app.add_flag("--grow", a.grow,
               "initial values from optimising the graph as it grows in the order of the file: for "
               "logs whose odometry drifts far");
  app.add_choice(
      "--robust", robust, kRobust,
      "against outliers among edges to landmarks and between vertices that are not neighbours in "
      "the file: "
      "a kernel, or gnc (graduated non-convexity with truncated least squares; gnc-gm: "
      "with Geman-McClure), which identifies them, or cycles (of poses alone; accepts loops by the "
      "cycles that they close, against groups of false loops that agree with each other; exit code "
      "3 if some remain undecided) (default none)");
  app.add_flag("--robust-all", a.robust_odometry, "edges between neighbours may be outliers too");
  app.add_positive("--robust-scale", a.options.kernel.scale,
                   "scale of the kernel in standard deviations");
  app.add_number("--inliers", a.inlier_probability, 0.5, 1.0 - 1e-12,
                 "share of inliers gnc and cycles are to keep if the information matrices are "
                 "consistent");
  app.add_flag(
      "--incremental", a.incremental,
      "add the graph edge by edge, with landmarks vertex by vertex, and solve after each; each "
      "pose is initialised by its first edge, each landmark where it is first seen");
  app.add_choice("--method", a.options.method, kMethods,
                 "gn: Gauss-Newton, falling back to lm where a step fails (default); lm: "
                 "Levenberg-Marquardt");
  app.add_number("--max-rises", a.options.max_rises, 0, 1'000'000,
                 "largest number of steps of gn in a row that leave the cost above the lowest");
  app.add_choice("--solver", a.solver, kSolvers,
                 "sparse Cholesky (default block: that of wayfare)");
  app.add_number("--threads", a.options.threads, 1, 256,
                 "worker threads; of the block solver; results do not depend on their number");
  app.add_number("--max-iterations", a.options.max_iterations, 1, 1'000'000,
                 "largest number of linear systems solved");
}

}  // namespace

std::optional<int> parse(int argc, char** argv, Arguments& a) {
  CommandLine app(
      "Optimise the graph of a g2o file, of poses or of poses and landmarks: prints the sum of "
      "e'We "
      "before and after (g2o's error, no factor 1/2), iterations and milliseconds, and writes the "
      "graph.");
  MaybeStart start;
  Robust robust;
  add_file_options(app, a);
  add_solver_options(app, a, start, robust);
  app.example("graph.g2o --out optimum.g2o", "optimises a graph");
  app.example("graph.g2o --robust gnc --rejected outliers.csv --out optimum.g2o",
              "the same with outliers among the loop closures");
  if (const auto code = app.parse(argc, argv)) return code;
  a.options.kernel.kind = robust.kernel;
  a.gnc = robust.gnc;
  a.cycles = robust.cycles;
  a.start_from_trusted = a.gnc && !start;
  a.start = start.value_or(StartMethod::given);
  return {};
}

}  // namespace wayfare::examples
