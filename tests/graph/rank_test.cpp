// Graphs whose edges leave directions open: named by every optimiser, whatever the angle.

#include <cmath>
#include <cstdint>
#include <string>
#include <type_traits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <wayfare/graph/gnc.hpp>
#include <wayfare/graph/incremental.hpp>
#include <wayfare/graph/optimise.hpp>

#include "graph/growth.hpp"
#include "graph/open_graph.hpp"
#include "graph/solvers.hpp"

namespace wayfare {
namespace {

using ::testing::HasSubstr;
using tests::NullSpace;
using tests::open_graph;
using tests::OpenShape;

constexpr OpenShape kShapes[] = {OpenShape::chain, OpenShape::tree, OpenShape::loops};

template <class G>
void scale(PoseGraph<G>& graph, double factor) {
  for (auto& edge : graph.edges) edge.information *= factor;
}

/// That a call failed and names a direction in which the graph is open.
template <class G>
void expect_named(const Error& error, const Undetermined<ManifoldTraits<G>::kDof>& open,
                  const NullSpace<G>& null) {
  EXPECT_EQ(error.code, ErrorCode::degenerate);
  EXPECT_THAT(error.message, HasSubstr("is not fully determined by the edges, along ("));
  ASSERT_GE(open.variable, 1) << error.message;
  EXPECT_NEAR(open.direction.norm(), 1.0, 1e-12);
  EXPECT_LT(null.distance(open.variable, open.direction), 1e-5) << error.message;
}

template <class Solver>
class OpenGraph : public ::testing::Test {};
TYPED_TEST_SUITE(OpenGraph, AllSolvers);

TYPED_TEST(OpenGraph, IsNamedByBatchCovariancesAndIncrementalAlike) {
  using G = std::conditional_t<TypeParam::kBlock == 3, SE2d, SE3d>;
  int graphs = 0;
  for (const OpenShape shape : kShapes) {
    for (int directions = 1; directions <= 3; ++directions) {
      for (std::uint64_t seed = 1; seed <= 25; ++seed) {
        SCOPED_TRACE(std::to_string(static_cast<int>(shape)) + ", " + std::to_string(directions) +
                     " directions, seed " + std::to_string(seed));
        Rng rng(seed);
        auto graph = open_graph<G>(rng, shape, directions);
        const NullSpace<G> null(graph);
        ASSERT_EQ(null.dimension(), directions);
        scale(graph, seed % 3 == 0 ? 1e-8 : seed % 3 == 1 ? 1.0 : 1e8);
        const auto before = graph.poses;
        PoseGraphOptimiser<G, TypeParam> batch;
        for (const auto method :
             {OptimiseMethod::gauss_newton, OptimiseMethod::levenberg_marquardt}) {
          const auto report = batch.optimise(graph, {.method = method});
          ASSERT_FALSE(report);
          expect_named(report.error(), batch.undetermined(), null);
          EXPECT_EQ(tests::apart(graph.poses, before), 0.0);
        }
        const auto covariances = batch.covariances(graph);
        ASSERT_FALSE(covariances);
        expect_named(covariances.error(), batch.undetermined(), null);
        IncrementalOptimiser<G> growing;
        ASSERT_TRUE(growing.append(graph));
        const auto update = growing.update();
        ASSERT_FALSE(update);
        expect_named(update.error(), growing.undetermined(), null);
        EXPECT_EQ(tests::apart(growing.poses(), before), 0.0);
        ++graphs;
      }
    }
  }
  EXPECT_EQ(graphs, 225);
}

// The same graphs with a little information left: at most 1e-7 of that of the other edges.
TYPED_TEST(OpenGraph, IsNoneWhereALittleIsSaid) {
  using G = std::conditional_t<TypeParam::kBlock == 3, SE2d, SE3d>;
  for (const OpenShape shape : kShapes) {
    for (std::uint64_t seed = 1; seed <= 25; ++seed) {
      Rng rng(seed);
      auto graph = open_graph<G>(rng, shape, 3, 1e-7);
      scale(graph, seed % 3 == 0 ? 1e-8 : seed % 3 == 1 ? 1.0 : 1e8);
      PoseGraphOptimiser<G, TypeParam> batch;
      const auto report = batch.optimise(graph);
      ASSERT_TRUE(report) << report.error().message;
      EXPECT_GE(report->final_cost, 0.0);
      EXPECT_TRUE(batch.covariances(graph));
      IncrementalOptimiser<G> growing;
      ASSERT_TRUE(growing.append(graph));
      EXPECT_TRUE(growing.update());
    }
  }
}

template <class G>
class OpenStart : public ::testing::Test {};
using Groups = ::testing::Types<SE2d, SE3d>;
TYPED_TEST_SUITE(OpenStart, Groups);

// A chain or a tree is undetermined wherever its poses are. The incremental optimiser leaves the
// undetermined part pending.
TYPED_TEST(OpenStart, MayLieAnywhere) {
  using G = TypeParam;
  for (const OpenShape shape : {OpenShape::chain, OpenShape::tree}) {
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
      Rng rng(seed);
      auto graph = open_graph<G>(rng, shape, 1 + static_cast<int>(seed % 3));
      for (auto& pose : graph.poses) pose = pose.plus(tests::random_tangent<G>(rng, 0.1));
      const auto before = graph.poses;
      for (const auto method : {OptimiseMethod::gauss_newton, OptimiseMethod::levenberg_marquardt})
        ASSERT_FALSE(optimise(graph, {.method = method}));
      ASSERT_FALSE(optimise_gnc(graph, {.start_from_trusted = false}));
      EXPECT_EQ(tests::apart(graph.poses, before), 0.0);
      PoseGraph<G> first = graph;  // its first group, which is rigid
      first.poses.resize(7);
      first.edges.resize(7);
      IncrementalOptimiser<G> growing;
      ASSERT_TRUE(growing.append(first));
      ASSERT_TRUE(growing.update());
      const auto solved = growing.poses();
      ASSERT_TRUE(growing.append(graph));
      for (int again = 0; again < 2; ++again) {
        ASSERT_FALSE(growing.update());
        EXPECT_GE(growing.undetermined().variable, 7);
        ASSERT_FALSE(growing.optimise_fully());
      }
      EXPECT_EQ(tests::apart({growing.poses().begin(), growing.poses().begin() + 7}, solved), 0.0);
    }
  }
}

// Two poses and one edge without information on y: undetermined along y of the second pose.
TEST(OpenPair, IsNamedAtEveryAngle) {
  for (int degrees = 0; degrees < 360; degrees += 5) {
    for (const double factor : {1e-8, 1.0, 1e8}) {
      const SE2d z(1.0, 2.0, Angle::degrees(degrees));
      const Eigen::Matrix3d information = Eigen::Vector3d(factor, 0.0, factor).asDiagonal();
      PoseGraph2 graph{
          {SE2d(), z * SE2d(0.3, 0.1, Angle{})}, {{0, 1, z, information, false}}, {}, {}};
      PoseGraphOptimiser<SE2d> batch;
      const auto report = batch.optimise(graph);
      ASSERT_FALSE(report) << degrees;
      EXPECT_EQ(report.error().message,
                "pose 1 is not fully determined by the edges, along (0, 1, 0)");
      EXPECT_NEAR(graph.poses[1].minus(z).y(), 0.1, 1e-12);
    }
  }
}

// The last ten edges of a chain have no information along one direction each: the direction of the
// first of them moves all later poses, and no others.
TEST(OpenChain, IsNamedAtEveryAngleAndItsCostIsNeverNegative) {
  for (int degrees = 0; degrees < 180; ++degrees) {
    const double a = degrees * 3.14159265358979323846 / 180.0;
    const Eigen::Vector3d n(std::cos(a), std::sin(a), 0.0);
    PoseGraph2 graph;
    graph.add_pose(SE2d());
    for (int i = 1; i <= 30; ++i) {
      const SE2d z(1.0, 0.0, 0.2_rad);
      Eigen::Matrix3d information = 100.0 * n * n.transpose();
      information(2, 2) = 100.0;
      if (i <= 20) information = 100.0 * Eigen::Matrix3d::Identity();
      graph.add_pose(graph.poses.back() * z);
      graph.edges.push_back({i - 1, i, z, information, false});
    }
    EXPECT_GE(chi2(graph), 0.0);
    for (const auto& edge : graph.edges) EXPECT_GE(squared_error(graph, edge), 0.0);
    PoseGraphOptimiser<SE2d> batch;
    NormalEquations<SE2d> equations;
    equations.set_structure(graph);
    EXPECT_GE(equations.linearise(graph, {}), 0.0);
    ASSERT_FALSE(batch.optimise(graph)) << degrees;
    EXPECT_GE(batch.undetermined().variable, 21) << degrees;
    ASSERT_FALSE(batch.covariances(graph)) << degrees;
    IncrementalOptimiser<SE2d> growing;
    ASSERT_TRUE(growing.append(graph));
    ASSERT_FALSE(growing.update()) << degrees;
  }
}

// A large map that may turn as a whole about pose 1, whose only edge to pose 0 has no information
// on the heading: the null vector moves distant poses many times as far as near ones.
TEST(HingedMap, IsNamedHoweverLarge) {
  for (const int width : {1, 30, 90}) {  // straight; or to and fro, joined to the row before
    for (const int poses : {300, 3000}) {
      PoseGraph2 graph;
      graph.add_pose(SE2d());
      for (int i = 1; i <= poses; ++i) {
        const int row = (i - 1) / width, along = (i - 1) % width;
        graph.add_pose(
            SE2d(1.0 + row, row % 2 == 0 ? along : width - 1 - along, Angle::radians(0.7 * i)));
        const auto join = [&](int from) {
          const SE2d z = graph.poses[static_cast<std::size_t>(from)].inverse() * graph.poses.back();
          graph.edges.push_back(
              {from, i, z, Eigen::Vector3d(400.0, 400.0, 2500.0).asDiagonal(), false});
        };
        join(i - 1);
        const int beside = i - 1 - 2 * along;
        if (width > 1 && row > 0 && beside > 0 && along > 0) join(beside);
      }
      graph.edges.front().information(2, 2) = 0.0;
      ASSERT_FALSE(optimise(graph)) << width << ' ' << poses;
      ASSERT_FALSE(PoseGraphOptimiser<SE2d>().covariances(graph)) << width << ' ' << poses;
      IncrementalOptimiser<SE2d> growing;
      ASSERT_TRUE(growing.append(graph));
      ASSERT_FALSE(growing.update()) << width << ' ' << poses;
      graph.edges.front().information(2, 2) = 1.0;
      ASSERT_TRUE(optimise(graph)) << width << ' ' << poses;
    }
  }
}

// A long chain loses digits to elimination in one order or another, but is determined: the end of
// one of length n is known to n³/3 of a step's variance.
TEST(LongChain, IsDetermined) {
  PoseGraph2 graph;
  graph.add_pose(SE2d());
  IncrementalOptimiser<SE2d> growing;
  ASSERT_TRUE(growing.add_pose(SE2d()));
  const Eigen::Matrix3d information = Eigen::Vector3d(400.0, 400.0, 2500.0).asDiagonal();
  for (int i = 1; i <= 5000; ++i) {
    const SE2d z(1.0, 0.0, Angle{});
    graph.add_pose(graph.poses.back() * z);
    graph.edges.push_back({i - 1, i, z, information, false});
    if (i % 50 != 0) continue;
    ASSERT_TRUE(growing.append(graph));
    ASSERT_TRUE(growing.update()) << i;
  }
  PoseGraphOptimiser<SE2d> batch;
  ASSERT_TRUE(batch.optimise(graph));
  const auto covariances = batch.covariances(graph);
  ASSERT_TRUE(covariances);
  // Σ k² σ_θ² over the k steps still to come, and σ_y² a step, 5000 of them.
  const double n = 5000.0, want = (n - 1.0) * n * (2.0 * n - 1.0) / 6.0 / 2500.0 + n / 400.0;
  EXPECT_NEAR(covariances->back()(1, 1), want, 1e-3 * want);
}

}  // namespace
}  // namespace wayfare
