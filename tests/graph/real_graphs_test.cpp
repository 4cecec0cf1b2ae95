// Optima of public pose graphs (Σ eᵀΩe of g2o's error).

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <ostream>
#include <string>

#include <wayfare/graph/incremental.hpp>
#include <wayfare/graph/optimise.hpp>
#include <wayfare/graph/pose_graph.hpp>
#include <wayfare/io/g2o.hpp>

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

TEST_P(RealGraph, ReachesThePublishedOptimumFromTheFilesPoses) {
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

// From the file's poses of city10000 the first full step raises the cost, and the second one lowers
// it by five orders of magnitude.
TEST(RealGraphs, TheWayOverARiseOfTheCostIsTheShorterOne) {
  WAYFARE_NEEDS_RECORDING(path, "posegraph/city10000.g2o.gz");
  const auto file = io::read_g2o(path);
  ASSERT_TRUE(file) << file.error().to_string();
  const PoseGraph2 start = io::to_pose_graph(std::get<io::GraphFile<SE2d>>(*file));
  auto graph = start;
  const auto over = optimise(graph, {.max_rises = 1});
  graph = start;
  const auto around = optimise(graph, {.max_rises = 0});
  ASSERT_TRUE(over && around);
  EXPECT_FALSE(over->fell_back);
  EXPECT_TRUE(around->fell_back);
  EXPECT_LE(over->iterations, 8);
  EXPECT_LE(over->iterations, around->iterations / 2);
  EXPECT_NEAR(over->final_cost, around->final_cost, 1e-5 * around->final_cost);
}

class RealGraphFromRelaxation : public RealGraph {};

TEST_P(RealGraphFromRelaxation, ReachesThePublishedOptimum) {
  const Optimum& expected = GetParam();
  WAYFARE_NEEDS_RECORDING(path, std::string("posegraph/") + expected.name + ".g2o.gz");
  const auto file = io::read_g2o(path);
  ASSERT_TRUE(file) << file.error().to_string();
  std::visit(
      [&](const auto& any) {
        auto graph = io::to_pose_graph(any);
        const auto& first = graph.poses.front();
        std::fill(graph.poses.begin() + 1, graph.poses.end(), first);
        ASSERT_TRUE(start_from_chordal(graph));
        EXPECT_LT(chi2(graph), 2.0 * expected.chi2);
        const auto report = optimise(graph);
        ASSERT_TRUE(report) << report.error().to_string();
        EXPECT_NEAR(report->final_chi2, expected.chi2, expected.tolerance);
      },
      *file);
}

class SoundGraph : public RealGraph {};

// Their edges determine every pose, in whatever unit of information.
TEST_P(SoundGraph, LeavesNothingOpenAtAnyScaleOfInformation) {
  WAYFARE_NEEDS_RECORDING(path, std::string("posegraph/") + GetParam().name + ".g2o.gz");
  const auto file = io::read_g2o(path);
  ASSERT_TRUE(file) << file.error().to_string();
  for (const double factor : {1e-8, 1.0, 1e8}) {
    std::visit(
        [&](const auto& any) {
          auto graph = io::to_pose_graph(any);
          using G = typename decltype(graph.poses)::value_type;
          for (auto& edge : graph.edges) edge.information *= factor;
          PoseGraphOptimiser<G> batch;
          const auto at_start = batch.covariances(graph);
          EXPECT_TRUE(at_start) << at_start.error().message;
          const auto report = batch.optimise(graph, {.max_iterations = 30});
          ASSERT_TRUE(report) << report.error().message;
          const auto covariances = batch.covariances(graph);
          EXPECT_TRUE(covariances) << covariances.error().message;
          IncrementalOptimiser<G> growing;
          ASSERT_TRUE(growing.append(graph));
          const auto update = growing.update();
          EXPECT_TRUE(update) << update.error().message;
        },
        *file);
  }
}

INSTANTIATE_TEST_SUITE_P(Shared, SoundGraph,
                         ::testing::Values(Optimum{"M3500", 0, 0}, Optimum{"M3500_odo", 0, 0},
                                           Optimum{"M3500_out100", 0, 0}, Optimum{"MIT", 0, 0},
                                           Optimum{"city10000", 0, 0}, Optimum{"intel", 0, 0},
                                           Optimum{"intel_943_odo", 0, 0},
                                           Optimum{"intel_943_odo_out100", 0, 0},
                                           Optimum{"parking-garage", 0, 0},
                                           Optimum{"smallGrid3D", 0, 0},
                                           Optimum{"sphere2500", 0, 0}),
                         [](const auto& instance) {
                           std::string name = instance.param.name;
                           std::erase_if(name, [](char c) { return c == '-' || c == '_'; });
                           return name;
                         });

std::string name_of(const ::testing::TestParamInfo<Optimum>& instance) {
  std::string name = instance.param.name;
  std::erase_if(name, [](char c) { return c == '-' || c == '_'; });
  return name;
}

INSTANTIATE_TEST_SUITE_P(
    Published, RealGraphFromRelaxation,
    ::testing::Values(Optimum{"MIT", 41.16, 5e-3}, Optimum{"intel", 45.005, 5e-4},
                      Optimum{"M3500_odo", 137.91, 5e-3}, Optimum{"city10000", 511.99, 5.1e-3},
                      Optimum{"sphere2500", 727.15, 5e-3}, Optimum{"parking-garage", 1.2387, 5e-5}),
    name_of);

INSTANTIATE_TEST_SUITE_P(Published, RealGraph,
                         ::testing::Values(Optimum{"intel", 45.005, 5e-4},
                                           Optimum{"M3500", 137.91, 5e-3},
                                           Optimum{"city10000", 511.99, 5.1e-3},
                                           Optimum{"sphere2500", 727.15, 5e-3},
                                           Optimum{"parking-garage", 1.2387, 5e-5}),
                         name_of);

}  // namespace
}  // namespace wayfare
