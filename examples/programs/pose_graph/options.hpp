#pragma once

#include <optional>
#include <string>

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
  io::G2oOptions file;
  StartMethod start = StartMethod::given;
  bool start_from_trusted = false;  ///< GNC's own initialisation, without --init
  SolverChoice solver = SolverChoice::block;
  std::optional<GncLoss> gnc;  ///< for graduated non-convexity
  bool cycles = false;         ///< loops accepted by the cycles they close
  bool robust_odometry = false;
  bool incremental = false;
  bool grow = false;
  double inlier_probability = GncOptions{}.inlier_probability;
  OptimiseOptions options;

  /// Whether edges are rejected.
  [[nodiscard]] bool rejects() const { return gnc || cycles; }
};

/// The exit code if the program is to end.
std::optional<int> parse(int argc, char** argv, Arguments& a);

}  // namespace wayfare::examples
