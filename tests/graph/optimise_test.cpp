#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cctype>
#include <limits>
#include <ostream>
#include <string>
#include <string_view>

#include <wayfare/core/random.hpp>
#include <wayfare/graph/optimise.hpp>

#include "solvers.hpp"

namespace wayfare {
namespace {

using ::testing::HasSubstr;

/// A square traversed twice, exactly measured, with wrong initial poses.
template <class G>
PoseGraph<G> square_walk(Rng& rng, double disturbance) {
  TangentOf<G> side = TangentOf<G>::Zero();
  side[0] = 1.0;
  side[G::kDof - 1] = 0.3;
  const G step = G::exp(side);
  PoseGraph<G> graph;
  G pose;
  for (int i = 0; i < 8; ++i, pose = pose * step) graph.add_pose(pose);
  const auto join = [&](int a, int b) {
    const auto &x = graph.poses[static_cast<std::size_t>(a)],
               &y = graph.poses[static_cast<std::size_t>(b)];
    graph.edges.push_back({a, b, x.inverse() * y, 10.0 * SquareOf<G>::Identity(), b != a + 1});
  };
  for (int i = 0; i + 1 < graph.size(); ++i) join(i, i + 1);
  join(7, 0);
  join(2, 6);
  for (int i = 1; i < graph.size(); ++i) {
    TangentOf<G> d;
    for (auto& v : d) v = rng.normal(0.0, disturbance);
    auto& x = graph.poses[static_cast<std::size_t>(i)];
    x = x.plus(d);
  }
  return graph;
}

template <class G>
class OptimiseTest : public ::testing::Test {};
using Groups = ::testing::Types<SE2d, SE3d>;
TYPED_TEST_SUITE(OptimiseTest, Groups);

TYPED_TEST(OptimiseTest, FindsExactMeasurementsByBothMethods) {
  for (const auto method : {OptimiseMethod::gauss_newton, OptimiseMethod::levenberg_marquardt}) {
    Rng rng(3);
    auto graph = square_walk<TypeParam>(rng, 0.1);
    const auto first = graph.poses[0];
    const auto report = optimise(graph, {.method = method});
    ASSERT_TRUE(report);
    EXPECT_LT(report->final_chi2, 1e-9);
    EXPECT_GT(report->initial_chi2, 1.0);
    EXPECT_EQ((graph.poses[0].minus(first)).norm(), 0.0) << "the first pose is held";
  }
}

TYPED_TEST(OptimiseTest, GrowsOnlineAndReusesTheStructureWhileNothingIsAdded) {
  Rng rng(4);
  auto graph = square_walk<TypeParam>(rng, 0.05);
  PoseGraphOptimiser<TypeParam> optimiser;
  EXPECT_FALSE(optimiser.optimise(graph)->structure_reused);
  EXPECT_TRUE(optimiser.optimise(graph)->structure_reused);
  const int added = graph.add_pose(graph.poses.back());
  graph.edges.push_back({added - 1, added, graph.edges[0].measurement});
  const auto report = optimiser.optimise(graph);
  ASSERT_TRUE(report);
  EXPECT_FALSE(report->structure_reused);
  EXPECT_LT(report->final_chi2, 1e-9);
}

TYPED_TEST(OptimiseTest, DoesNotMoveFixedPoses) {
  Rng rng(5);
  auto graph = square_walk<TypeParam>(rng, 0.1);
  graph.fixed = {3, 5};
  const auto before = graph.poses;
  ASSERT_TRUE(optimise(graph));
  EXPECT_EQ(graph.poses[3].minus(before[3]).norm(), 0.0);
  EXPECT_EQ(graph.poses[5].minus(before[5]).norm(), 0.0);
  EXPECT_GT(graph.poses[0].minus(before[0]).norm(), 1e-3);
}

TYPED_TEST(OptimiseTest, CovarianceGrowsAlongAChainByComposition) {
  // x2 = z01 z12 with independent errors of information Ω each: Σ₂ = Ad Σ Adᵀ + Σ.
  using G = TypeParam;
  TangentOf<G> tau = TangentOf<G>::Constant(0.2);
  const G z = G::exp(tau);
  PoseGraph<G> graph{{G(), z, z * z}, {}, {}, {}};
  SquareOf<G> information = SquareOf<G>::Identity() * 4.0;
  information(0, 0) = 9.0;
  for (const int i : {0, 1}) graph.edges.push_back({i, i + 1, z, information});
  PoseGraphOptimiser<G> optimiser;
  ASSERT_TRUE(optimiser.prepare_covariances(graph));
  // At zero error, translation is a right perturbation; a quaternion's vector part is half of one.
  const auto j = PoseError<G>::linearise(z, G(), z).by_to;
  const SquareOf<G> sigma = (j.transpose() * information * j).inverse();
  const SquareOf<G> move = z.inverse().adjoint();
  EXPECT_LT((optimiser.covariance(1) - sigma).norm(), 1e-12);
  EXPECT_LT((optimiser.covariance(2) - (move * sigma * move.transpose() + sigma)).norm(), 1e-12);
  EXPECT_LT((optimiser.relative_covariance(graph, 1, 2) - sigma).norm(), 1e-12);
  EXPECT_EQ(optimiser.covariance(0).norm(), 0.0);
}

TYPED_TEST(OptimiseTest, RobustKernelsSuppressAFalseLoop) {
  for (const auto kind : {RobustKernelKind::cauchy, RobustKernelKind::geman_mcclure,
                          RobustKernelKind::dynamic_covariance_scaling}) {
    Rng rng(6);
    auto graph = square_walk<TypeParam>(rng, 0.0);
    const auto truth = graph.poses;
    graph.edges.push_back({1, 5, TypeParam(), SquareOf<TypeParam>::Identity() * 10.0, true});
    auto plain = graph;
    ASSERT_TRUE(optimise(plain));
    ASSERT_TRUE(optimise(graph, {.kernel = {kind, 1.0}}));
    const double robust_error = graph.poses[5].minus(truth[5]).norm();
    EXPECT_LT(robust_error, 0.2 * plain.poses[5].minus(truth[5]).norm());
  }
}

// A first step that raises the cost uses up the only iteration: no progress, but no error of the
// graph either.
TEST(Optimise, RunningOutOfIterationsIsNoError) {
  int refused = 0;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    Rng rng(seed);
    auto graph = square_walk<SE2d>(rng, 1.5);
    const auto report = optimise(graph, {.max_iterations = 1});
    ASSERT_TRUE(report) << report.error().to_string();
    EXPECT_LE(report->final_cost, report->initial_cost);
    refused += report->history.front().accepted ? 0 : 1;
  }
  EXPECT_GT(refused, 0);
}

TEST(Optimise, StopsOnRequest) {
  Rng rng(3);
  auto graph = square_walk<SE2d>(rng, 0.1);
  const auto report = optimise(graph, {.progress = [](int, const auto&) { return false; }});
  ASSERT_TRUE(report);
  EXPECT_EQ(report->iterations, 1);
  EXPECT_EQ(report->reason, StopReason::stopped);
}

struct Fault {
  const char* message;
  void (*spoil)(PoseGraph2&);
};
void PrintTo(const Fault& fault, std::ostream* out) { *out << fault.message; }
std::string letters_of(std::string_view message) {
  std::string name;
  for (const char c : message)
    if (std::isalnum(static_cast<unsigned char>(c)) != 0) name += c;
  return name;
}
class FaultyGraph : public ::testing::TestWithParam<Fault> {};

TEST_P(FaultyGraph, IsRejectedByNameAndUnchanged) {
  Rng rng(3);
  auto graph = square_walk<SE2d>(rng, 0.1);
  GetParam().spoil(graph);
  const SE2d sample = graph.poses.size() > 2 ? graph.poses[2] : SE2d();
  const auto report = optimise(graph);
  ASSERT_FALSE(report);
  EXPECT_THAT(report.error().message, HasSubstr(GetParam().message));
  if (graph.poses.size() > 2) {
    EXPECT_EQ(graph.poses[2].x(), sample.x());
  }
}

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
INSTANTIATE_TEST_SUITE_P(
    Faults, FaultyGraph,
    ::testing::Values(
        Fault{"no poses", [](PoseGraph2& g) { g = {}; }},
        Fault{"pose 8 is not connected to pose 0", [](PoseGraph2& g) { g.add_pose({}); }},
        Fault{"pose 0 is not connected to pose 8",
              [](PoseGraph2& g) { g.fixed = {g.add_pose({})}; }},
        Fault{"pose 4 is not finite", [](PoseGraph2& g) { g.poses[4] = SE2d(kNan, 0.0, 0.0_rad); }},
        Fault{"edge 2 (3 -> 3) joins a pose to itself",
              [](PoseGraph2& g) { g.edges[2].from = g.edges[2].to; }},
        Fault{"names pose 99", [](PoseGraph2& g) { g.edges[2].to = 99; }},
        Fault{"edge 0 (0 -> 1) has zero information",
              [](PoseGraph2& g) { g.edges[0].information.setZero(); }},
        Fault{"edge 1 (1 -> 2) has an information matrix that is not positive semi-definite",
              [](PoseGraph2& g) { g.edges[1].information(1, 1) = -1.0; }},
        Fault{"edge 1 (1 -> 2) has an information that is not finite",
              [](PoseGraph2& g) { g.edges[1].information(1, 1) = kNan; }},
        Fault{"edge 1 (1 -> 2) has a measurement that is not finite",
              [](PoseGraph2& g) { g.edges[1].measurement = SE2d(0.0, kNan, 0.0_rad); }},
        Fault{"edge 1 (1 -> 2) has an error too large to square",
              [](PoseGraph2& g) { g.edges[1].measurement = SE2d(1e200, 0.0, 0.0_rad); }},
        Fault{"fixed pose -1", [](PoseGraph2& g) { g.fixed = {-1}; }},
        Fault{"fixed pose 8", [](PoseGraph2& g) { g.fixed = {8}; }}),
    [](const auto& instance) { return letters_of(instance.param.message); });

template <class Solver>
class AnUndeterminedPose : public ::testing::Test {};
TYPED_TEST_SUITE(AnUndeterminedPose, AllSolvers);

// A chain whose last edge has no information about the heading.
TYPED_TEST(AnUndeterminedPose, IsNamedAndTheGraphUnchanged) {
  using G = std::conditional_t<TypeParam::kBlock == 3, SE2d, SE3d>;
  Rng rng(3);
  auto graph = square_walk<G>(rng, 0.1);
  const int last = graph.add_pose(graph.poses.back());
  SquareOf<G> information = SquareOf<G>::Identity();
  information(G::kDof - 1, G::kDof - 1) = 0.0;
  graph.edges.push_back({7, last, G(), information});
  const auto before = graph.poses;
  PoseGraphOptimiser<G, TypeParam> optimiser;
  const auto report = optimiser.optimise(graph);
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().code, ErrorCode::degenerate);
  EXPECT_EQ(report.error().message,
            std::string("pose 8 is not fully determined by the edges, along ") +
                (G::kDof == 3 ? "(0, 0, 1)" : "(0, 0, 0, 0, 0, 1)"));
  EXPECT_EQ(optimiser.undetermined().variable, 8);
  EXPECT_NEAR(optimiser.undetermined().direction[G::kDof - 1], 1.0, 1e-12);
  for (std::size_t k = 0; k < before.size(); ++k)
    EXPECT_EQ(graph.poses[k].minus(before[k]).norm(), 0.0);
  const auto covariances = optimiser.prepare_covariances(graph);
  ASSERT_FALSE(covariances);
  EXPECT_THAT(covariances.error().message, HasSubstr("pose 8"));
}

// On an overflow the solver may not be able to name a pivot.
TYPED_TEST(AnUndeterminedPose, IsNamedWhereTheNumbersOverflow) {
  using G = std::conditional_t<TypeParam::kBlock == 3, SE2d, SE3d>;
  Rng rng(3);
  auto graph = square_walk<G>(rng, 0.1);
  graph.edges.push_back(
      {7, graph.add_pose(graph.poses.back()), G(), 1.5e308 * SquareOf<G>::Identity()});
  graph.edges.push_back(graph.edges.back());
  const auto report = PoseGraphOptimiser<G, TypeParam>().optimise(graph);
  ASSERT_FALSE(report);
  EXPECT_THAT(report.error().message, ::testing::MatchesRegex("pose [78] is not.*"));
}

}  // namespace
}  // namespace wayfare
