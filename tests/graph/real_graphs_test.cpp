// Optima of public pose graphs (Σ eᵀΩe of g2o's error).

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <ostream>

#include <wayfare/graph/optimise.hpp>
#include <wayfare/io/pose_graph_file.hpp>

#include "io/support.hpp"

namespace wayfare {
namespace {

struct Optimum {
  const char* name;
  double chi2;
  double tolerance;  // half a unit of the last published digit
};

void PrintTo(const Optimum& optimum, std::ostream* out) { *out << optimum.name; }

class RealGraph : public ::testing::TestWithParam<Optimum> {};

TEST_P(RealGraph, ReachesThePublishedOptimumFromTheFilesOwnStart) {
  const Optimum& expected = GetParam();
  WAYFARE_NEEDS_RECORDING(path, std::string("posegraph/") + expected.name + ".g2o.gz");
  const auto file = io::read_g2o(path);
  ASSERT_TRUE(file) << file.error().to_string();
  for (const auto method : {OptimiseMethod::gauss_newton, OptimiseMethod::levenberg_marquardt}) {
    std::visit(
        [&](const auto& any) {
          auto graph = io::to_pose_graph(any);
          const auto report = optimise(graph, {.method = method});
          ASSERT_TRUE(report) << report.error().to_string();
          EXPECT_NEAR(report->final_chi2, expected.chi2, expected.tolerance);
          EXPECT_EQ(report->reason, StopReason::converged);
        },
        *file);
  }
}

INSTANTIATE_TEST_SUITE_P(Published, RealGraph,
                         ::testing::Values(Optimum{"intel", 45.005, 5e-4},
                                           Optimum{"M3500", 137.91, 5e-3},
                                           Optimum{"city10000", 511.99, 5.1e-3},
                                           Optimum{"sphere2500", 727.15, 5e-3},
                                           Optimum{"parking-garage", 1.2387, 5e-5}),
                         [](const auto& instance) {
                           std::string name = instance.param.name;
                           std::erase(name, '-');
                           return name;
                         });

}  // namespace
}  // namespace wayfare
