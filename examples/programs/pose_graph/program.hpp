#pragma once

#include <optional>
#include <string>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/graph/gnc.hpp>
#include <wayfare/graph/pose_graph.hpp>
#include <wayfare/graph/report.hpp>
#include <wayfare/io/g2o.hpp>

#include "support/program_files.hpp"

namespace wayfare::examples {

enum class SolverChoice { block, eigen, cholmod };

struct Arguments : OutputArguments {
  std::string input;
  std::string svg, marginals, rejected;  ///< empty: not written
  io::IndefiniteInformation indefinite = io::IndefiniteInformation::refuse;
  StartMethod start = StartMethod::given;
  bool start_from_trusted = false;  ///< GNC's own initialisation, without --init
  SolverChoice solver = SolverChoice::block;
  std::optional<GncLoss> gnc;  ///< for graduated non-convexity
  bool robust_odometry = false;
  bool incremental = false;
  double inlier_probability = GncOptions{}.inlier_probability;
  OptimiseOptions options;
};

/// The exit code if the program is to end.
[[nodiscard]] std::optional<int> parse(int argc, char** argv, Arguments& a);

struct Outcome {
  OptimiseReport report;
  double start_s = 0.0;
  double total_s = 0.0;       ///< of the optimisation
  int rounds = 0;             ///< of graduated non-convexity
  std::vector<int> rejected;  ///< outlier edges
};

/// Initialises the poses by --init, stores them in `initial` and optimises them.
template <LieGroup G>
Result<Outcome> solve(PoseGraph<G>& graph, const Arguments& a, std::vector<G>& initial);

/// An SVG of the graph with the poses `before` and with its poses; `rejected` are edges.
template <LieGroup G>
[[nodiscard]] std::string draw(const PoseGraph<G>& graph, const std::vector<G>& before,
                               const std::vector<int>& rejected);

/// One row per pose: label and upper triangle of the covariance, units in the heading. Without the
/// `rejected` edges.
template <LieGroup G>
[[nodiscard]] Result<std::string> marginals_table(const PoseGraph<G>& graph,
                                                  const std::vector<int>& rejected,
                                                  const RobustKernel& kernel);

/// One row per edge: the labels of its vertices.
template <LieGroup G>
[[nodiscard]] std::string edges_table(const PoseGraph<G>& graph, const std::vector<int>& edges);

}  // namespace wayfare::examples
