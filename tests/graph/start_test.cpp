#include <wayfare/graph/pose_graph.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tangle.hpp"

namespace wayfare {
namespace {

using ::testing::HasSubstr;
using tests::random_tangent;

constexpr StartMethod kComputed[] = {StartMethod::odometry, StartMethod::tree,
                                     StartMethod::chordal};

template <class G>
class StartTest : public ::testing::Test {
 protected:
  static constexpr int kDof = G::kDof;
  Rng rng_{21};

  SquareOf<G> random_information() {
    SquareOf<G> information = 0.1 * SquareOf<G>::Identity();
    for (int k = 0; k < kDof; ++k) {
      const TangentOf<G> v = random_tangent<G>(rng_, 3.0);
      information += v * v.transpose();
    }
    return information;
  }

  /// A chain and as many loops, edges in both directions, measured exactly.
  PoseGraph<G> exact_graph(int poses) {
    PoseGraph<G> graph;
    for (int i = 0; i < poses; ++i) graph.add_pose(G::exp(random_tangent<G>(rng_, 3.0)));
    for (int i = 1; i < poses; ++i) join(graph, i - 1, i, false);
    for (int i = 0; i < poses; ++i) join(graph, i, (7 * i + 3) % poses, true);
    return graph;
  }

  void join(PoseGraph<G>& graph, int a, int b, bool robust) {
    if (a == b) return;
    if (rng_.uniform(0, 1) < 0.5) std::swap(a, b);
    const G z = graph.poses[static_cast<std::size_t>(a)].inverse() *
                graph.poses[static_cast<std::size_t>(b)];
    graph.edges.push_back({a, b, z, random_information(), robust});
  }

  /// Random values of the free poses.
  void scatter(PoseGraph<G>& graph) {
    for (int i = 0; i < graph.size(); ++i) {
      const bool held = graph.fixed.empty() ? i == 0 : std::ranges::count(graph.fixed, i) > 0;
      if (!held) graph.poses[static_cast<std::size_t>(i)] = G::exp(random_tangent<G>(rng_, 3.0));
    }
  }

  static double furthest(const PoseGraph<G>& graph, const std::vector<G>& truth) {
    double worst = 0.0;
    for (std::size_t i = 0; i < truth.size(); ++i)
      worst = std::max(worst, graph.poses[i].minus(truth[i]).norm());
    return worst;
  }
};
using Groups = ::testing::Types<SE2d, SE3d>;
TYPED_TEST_SUITE(StartTest, Groups);

TYPED_TEST(StartTest, ExactMeasurementsGiveTheTruthByEveryMethod) {
  for (const auto& fixed : {std::vector<int>{}, {17}, {40, 3, 9}}) {
    auto graph = this->exact_graph(41);
    graph.fixed = fixed;
    const auto truth = graph.poses;
    for (const StartMethod method : kComputed) {
      this->scatter(graph);
      ASSERT_GT(this->furthest(graph, truth), 1.0);
      ASSERT_TRUE(start_from(graph, method));
      EXPECT_LT(this->furthest(graph, truth), 1e-9) << static_cast<int>(method);
    }
    this->scatter(graph);
    const auto scattered = graph.poses;
    ASSERT_TRUE(start_from(graph, StartMethod::given));
    EXPECT_EQ(this->furthest(graph, scattered), 0.0);
  }
}

TYPED_TEST(StartTest, TheTreePrefersTrustedEdges) {
  auto graph = this->exact_graph(41);
  const auto truth = graph.poses;
  for (auto& edge : graph.edges)
    if (edge.robust) edge.measurement = TypeParam::exp(random_tangent<TypeParam>(this->rng_, 3.0));
  ASSERT_TRUE(start_from_tree(graph, TreeEdges::trusted_first));
  EXPECT_LT(this->furthest(graph, truth), 1e-9);
  ASSERT_TRUE(start_from_tree(graph, TreeEdges::any));
  EXPECT_GT(this->furthest(graph, truth), 0.1);
  // An untrusted edge is used if there is no other path.
  graph.poses = truth;
  std::erase_if(graph.edges, [](const auto& e) { return std::max(e.from, e.to) == 40; });
  this->join(graph, 40, 2, true);
  std::swap(graph.edges.back(), graph.edges.front());
  this->scatter(graph);
  ASSERT_TRUE(start_from_tree(graph, TreeEdges::trusted_first));
  EXPECT_LT(this->furthest(graph, truth), 1e-9);
}

// Two paths to a pose: one edge with σ = 1 m, two with 0.1 m each.
TYPED_TEST(StartTest, TheTreePrefersTheLessUncertainPathToTheShorterOne) {
  using G = TypeParam;
  const auto ahead = [](double x) { return G(G::Vector::Unit(0) * x, G().rotation()); };
  PoseGraph<G> graph;
  graph.poses.resize(3);
  const SquareOf<G> vague = SquareOf<G>::Identity();
  graph.edges = {{0, 2, ahead(9.0), vague, false},
                 {0, 1, ahead(1.0), 100.0 * vague, false},
                 {1, 2, ahead(1.0), 100.0 * vague, false}};
  ASSERT_TRUE(start_from_tree(graph));
  EXPECT_EQ(graph.poses[2].translation()[0], 2.0);
  graph.edges[0].information *= 1000.0;
  ASSERT_TRUE(start_from_tree(graph));
  EXPECT_EQ(graph.poses[2].translation()[0], 9.0);
}

// Size of a path: Σ var x + var y + (2 m)² var θ. An edge of 0.4 + 0.2 m² and 0.1 rad², 1 m² in
// all, against two of var θ each, 8 · 0.12 or 8 · 0.13 m².
TEST(StartInThePlane, ARotationCountsAsTwoMetres) {
  const auto ahead = [](double x) { return SE2d(x, 0.0, Angle()); };
  constexpr double kExact = 1e12;
  for (const auto& [variance, x] : {std::pair{0.12, 2.0}, {0.13, 9.0}}) {
    const Eigen::Matrix3d turns = Eigen::Vector3d(kExact, kExact, 1.0 / variance).asDiagonal();
    PoseGraph<SE2d> graph;
    graph.poses.resize(3);
    graph.edges = {{0, 2, ahead(9.0), Eigen::Vector3d(2.5, 5.0, 10.0).asDiagonal(), false},
                   {0, 1, ahead(1.0), turns, false},
                   {1, 2, ahead(1.0), turns, false}};
    ASSERT_TRUE(start_from_tree(graph));
    EXPECT_EQ(graph.poses[2].translation()[0], x) << variance;
  }
}

// In space, var x + var y + var z + (2 m)² var θ: three of 0.2 m² and a rotation of 0.1 rad²
// against two of 0.12 or 0.13 rad². The information is that of a quaternion's vector part, half the
// angle.
TEST(StartInSpace, ARotationCountsAsTwoMetres) {
  const auto ahead = [](double x) { return SE3d(Eigen::Vector3d(x, 0.0, 0.0), SO3d()); };
  const auto information = [](double place, double turn) {
    constexpr double kExact = 1e12;
    Eigen::Matrix<double, 6, 1> w;
    w << place, place, place, kExact, 4.0 * turn, kExact;
    return Eigen::Matrix<double, 6, 6>(w.asDiagonal());
  };
  for (const auto& [variance, x] : {std::pair{0.12, 2.0}, {0.13, 9.0}}) {
    PoseGraph<SE3d> graph;
    graph.poses.resize(3);
    graph.edges = {{0, 2, ahead(9.0), information(1.0 / 0.2, 1.0 / 0.1), false},
                   {0, 1, ahead(1.0), information(1e12, 1.0 / variance), false},
                   {1, 2, ahead(1.0), information(1e12, 1.0 / variance), false}};
    ASSERT_TRUE(start_from_tree(graph));
    EXPECT_EQ(graph.poses[2].translation()[0], x) << variance;
  }
}

// A ring of n equal steps that rotate by α each, where nα is not a full turn. With w_k = z_k
// e^(−ikα) for headings z_k the relaxation minimises Σ|w_(k+1) − w_k|² between w_0 = 1 and w_n =
// e^(−inα): a straight line. Equal weights distribute the translation's gap evenly as well.
TYPED_TEST(StartTest, ChordalEqualsTheClosedFormOnARing) {
  using G = TypeParam;
  using Complex = std::complex<double>;
  constexpr int kPoses = 12;
  constexpr double kTurn = 2.0 * std::numbers::pi / kPoses + 0.04;
  TangentOf<G> twist = TangentOf<G>::Zero();
  twist[G::kDof - 1] = kTurn;
  typename G::Vector ahead = G::Vector::Unit(0);
  const G step(ahead, G::exp(twist).rotation());
  PoseGraph<G> graph;
  for (int i = 0; i < kPoses; ++i) {
    graph.add_pose(G());
    graph.edges.push_back({i, (i + 1) % kPoses, step, 3.0 * SquareOf<G>::Identity()});
  }
  ASSERT_TRUE(start_from_chordal(graph));
  std::array<Complex, kPoses + 1> heading, place{};
  for (int k = 0; k <= kPoses; ++k) {
    const Complex line = 1.0 + (std::polar(1.0, -kPoses * kTurn) - 1.0) * (double(k) / kPoses);
    heading[std::size_t(k)] = std::polar(1.0, k * kTurn) * line / std::abs(line);
    if (k > 0) place[std::size_t(k)] = place[std::size_t(k - 1)] + heading[std::size_t(k - 1)];
  }
  for (int k = 0; k < kPoses; ++k) {
    const Complex want = place[std::size_t(k)] - place[kPoses] * (double(k) / kPoses);
    const auto& x = graph.poses[std::size_t(k)];
    EXPECT_NEAR(std::abs(Complex(x.translation()[0], x.translation()[1]) - want), 0.0, 1e-12);
    const auto forward = (x.rotation() * ahead).eval();
    EXPECT_NEAR(std::abs(Complex(forward[0], forward[1]) - heading[std::size_t(k)]), 0.0, 1e-12);
  }
}

// Given the rotations, no other translations have a smaller cost.
TYPED_TEST(StartTest, ChordalTranslationsAreOptimalForTheirRotations) {
  using G = TypeParam;
  auto graph = this->exact_graph(12);
  for (auto& e : graph.edges)
    e.measurement = e.measurement.plus(random_tangent<G>(this->rng_, 0.2));
  ASSERT_TRUE(start_from_chordal(graph));
  const double best = chi2(graph);
  for (int trial = 0; trial < 200; ++trial) {
    auto moved = graph;
    auto& x = moved.poses[1 + this->rng_.below(11)];
    TangentOf<G> shift = random_tangent<G>(this->rng_, 1e-3);
    shift.template tail<G::kDof - G::Vector::RowsAtCompileTime>().setZero();
    x = x * G::exp(shift);
    EXPECT_GT(chi2(moved), best);
  }
}

TYPED_TEST(StartTest, UnconnectedPosesAreNamedAndThePosesUnchanged) {
  using G = TypeParam;
  constexpr int N = static_cast<int>(G::Vector::RowsAtCompileTime);
  auto graph = this->exact_graph(6);
  this->scatter(graph);
  const auto before = graph.poses;
  const auto fault = [&](StartMethod method) {
    const auto done = start_from(graph, method);
    EXPECT_EQ(this->furthest(graph, before), 0.0);
    return done ? "" : done.error().message;
  };
  const auto edges = graph.edges;
  // Pose 5 remains connected by loops, not by odometry.
  std::erase_if(graph.edges, [](const auto& e) { return e.from + e.to == 9; });
  EXPECT_THAT(fault(StartMethod::odometry), HasSubstr("no odometry edge joins poses 4 and 5"));
  graph.edges = edges;
  for (auto& e : graph.edges)
    if (std::max(e.from, e.to) == 5)
      e.information.template rightCols<G::kDof - N>().setZero(),
          e.information.template bottomRows<G::kDof - N>().setZero();
  EXPECT_THAT(fault(StartMethod::chordal),
              HasSubstr("pose 5 is not connected to pose 0 by edges that measure rotation"));
  graph.edges = edges;
  for (auto& e : graph.edges)
    if (std::max(e.from, e.to) == 5)
      e.information.template leftCols<N>().setZero(), e.information.template topRows<N>().setZero();
  EXPECT_THAT(fault(StartMethod::chordal),
              HasSubstr("pose 5 is not connected to pose 0 by edges that measure translation"));
  // A new pose, of whose position only x is known.
  graph.edges = edges;
  SquareOf<G> across = SquareOf<G>::Identity();
  across(1, 1) = 0.0;
  auto more = graph;
  more.poses[0] = G();
  more.edges.push_back({0, more.add_pose(G()), G(), across});
  EXPECT_THAT(start_from_chordal(more).error().message,
              HasSubstr("the translation of pose 6 is not determined by the edges"));
  graph.edges.clear();
  for (const StartMethod method : kComputed)
    EXPECT_THAT(fault(method), HasSubstr("pose 1 is not connected to pose 0"));
}

}  // namespace
}  // namespace wayfare
