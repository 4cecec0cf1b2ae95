#include <wayfare/graph/loop_consistency.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <Eigen/Cholesky>
#include <Eigen/LU>

#include <wayfare/core/random.hpp>
#include <wayfare/core/statistics.hpp>
#include <wayfare/graph/optimise.hpp>

#include "tangle.hpp"

namespace wayfare {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using tests::random_tangent;

constexpr double kNoise_m = 0.02, kNoise_rad = 0.01;

/// Laps on a square of four streets, with loops between the laps.
template <class G>
class Laps {
 public:
  static constexpr int kDof = G::kDof;
  static constexpr int kLap = 40;

  explicit Laps(int poses, std::uint64_t seed) : rng_(seed) {
    for (int i = 0; i < poses; ++i) {
      graph_.poses.push_back(i == 0 ? G() : graph_.poses.back() * step(i - 1));
      if (i > 0) join(i - 1, i, false);
    }
    for (int i = 0; i + kLap < poses; i += 2) join(i, i + kLap, true);
  }

  [[nodiscard]] const PoseGraph<G>& graph() const { return graph_; }
  [[nodiscard]] const G& at(int i) const { return graph_.poses[static_cast<std::size_t>(i)]; }

  /// Appends `size` loops that agree with each other: the places i and j are the same.
  void add_group(int i, int j, int size) {
    for (int k = 0; k < size; ++k) {
      PoseEdge<G> edge = graph_.edges.back();
      edge.from = i + k, edge.to = j + k, edge.robust = true;
      const G from = at(i).inverse() * at(i + k), to = at(j).inverse() * at(j + k);
      edge.measurement = noisy(from.inverse() * to);
      graph_.edges.push_back(edge);
    }
  }

 private:
  static G step(int i) {
    TangentOf<G> ahead = TangentOf<G>::Zero(), turn = TangentOf<G>::Zero();
    ahead[0] = 1.0;
    if (i % 10 == 9) turn[kDof - 1] = std::numbers::pi / 2.0;
    return G::exp(ahead) * G::exp(turn);
  }
  static double sigma(int k) {
    return k >= static_cast<int>(G::Vector::RowsAtCompileTime) ? kNoise_rad : kNoise_m;
  }

  [[nodiscard]] G noisy(const G& z) {
    TangentOf<G> noise;
    for (int k = 0; k < kDof; ++k) noise[k] = rng_.normal(0.0, sigma(k));
    return z.plus(noise);
  }

  void join(int i, int j, bool loop) {
    SquareOf<G> information = SquareOf<G>::Zero();
    for (int k = 0; k < kDof; ++k)  // a quaternion's vector part is half the angle
      information(k, k) = (sigma(k) == kNoise_rad && kDof == 6 ? 4.0 : 1.0) / (sigma(k) * sigma(k));
    graph_.edges.push_back({i, j, noisy(at(i).inverse() * at(j)), information, loop});
  }

  Rng rng_;
  PoseGraph<G> graph_;
};

std::vector<int> from_to(std::size_t first, std::size_t end) {
  std::vector<int> all;
  for (std::size_t k = first; k < end; ++k) all.push_back(static_cast<int>(k));
  return all;
}

void expect_same(const auto& a, const auto& b) {
  EXPECT_EQ(a.translation(), b.translation());
  EXPECT_EQ(a.rotation().matrix(), b.rotation().matrix());
}

template <class G>
class LoopConsistency : public ::testing::Test {};
using Groups = ::testing::Types<SE2d, SE3d>;
TYPED_TEST_SUITE(LoopConsistency, Groups);

TYPED_TEST(LoopConsistency, WithoutFalseLoopsItIsTheOptimum) {
  auto graph = Laps<TypeParam>(160, 1).graph();
  auto plain = graph;
  ASSERT_TRUE(optimise(plain));
  const auto report = optimise_consistent_loops(graph);
  ASSERT_TRUE(report) << report.error().to_string();
  EXPECT_THAT(report->rejected, IsEmpty());
  EXPECT_NEAR(report->optimisation.final_chi2, chi2(plain), 1e-6 * chi2(plain));
}

TYPED_TEST(LoopConsistency, FindsGroupsThatAgreeWithThemselves) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    Laps<TypeParam> laps(200, seed);
    auto clean = laps.graph();
    ASSERT_TRUE(optimise(clean));
    // As many false loops as true ones: 80.
    for (const int place : {3, 24, 47, 65}) laps.add_group(place, place + 95, 20);
    auto graph = laps.graph();
    const auto report = optimise_consistent_loops(graph);
    ASSERT_TRUE(report) << report.error().to_string();
    EXPECT_EQ(report->rejected, from_to(clean.edges.size(), graph.edges.size()));
    EXPECT_NEAR(report->optimisation.final_chi2, chi2(clean), 1e-4 * chi2(clean));
  }
}

/// Σ eᵀΩe of the trusted edges and the loops of `subset`, at its optimum.
template <class G>
double cost_of(PoseGraph<G> graph, const std::vector<std::size_t>& loops, unsigned subset) {
  std::vector<PoseEdge<G>> edges;
  for (const auto& edge : graph.edges)
    if (!edge.robust) edges.push_back(edge);
  for (std::size_t k = 0; k < loops.size(); ++k)
    if ((subset >> k & 1U) != 0) edges.push_back(graph.edges[loops[k]]);
  graph.edges = edges;
  const auto report = optimise(graph);
  return report ? report->final_chi2 : std::numeric_limits<double>::infinity();
}

// The oracle: of all subsets of the loops, the largest whose joint error χ² passes its quantile, as
// all loops together with the odometry have dof × (number of loops) redundant measurements.
TYPED_TEST(LoopConsistency, IsTheLargestConsistentSetOfSmallGraphs) {
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U}) {
    Laps<TypeParam> laps(50, seed);  // five true loops
    laps.add_group(5, 20, 2);
    laps.add_group(12, 35, 1);
    auto graph = laps.graph();
    std::vector<std::size_t> loops;
    for (std::size_t k = 0; k < graph.edges.size(); ++k)
      if (graph.edges[k].robust) loops.push_back(k);
    ASSERT_EQ(loops.size(), 8U);
    int most = -1;
    unsigned best = 0;
    for (unsigned subset = 0; subset < 1U << loops.size(); ++subset) {
      const int count = __builtin_popcount(subset);
      if (count <= most) continue;
      if (count == 0 || cost_of(graph, loops, subset) <
                            chi_square_quantile(0.9999, count * ManifoldTraits<TypeParam>::kDof))
        most = count, best = subset;
    }
    std::vector<int> want;
    for (std::size_t k = 0; k < loops.size(); ++k)
      if ((best >> k & 1U) == 0) want.push_back(static_cast<int>(loops[k]));
    const auto report = optimise_consistent_loops(graph);
    ASSERT_TRUE(report) << report.error().to_string();
    EXPECT_EQ(report->rejected, want) << seed;
  }
}

TYPED_TEST(LoopConsistency, SaysWhatItDoesNotDecide) {
  // One loop after 40 steps, whose error has the scatter of the steps, not its own: it agrees, but
  // it is not taken back at the optimum without it.
  const auto graph = Laps<TypeParam>(42, 1).graph();
  const auto rejected = [&](double max_false) {
    auto copy = graph;
    const auto report =
        optimise_consistent_loops(copy, {.max_false = max_false, .noise_scale = 1.0});
    EXPECT_TRUE(report);
    EXPECT_EQ(report->undecided, report->rejected);
    return report->rejected;
  };
  EXPECT_THAT(rejected(LoopConsistencyOptions{}.max_false), IsEmpty());
  EXPECT_EQ(rejected(0.0), std::vector<int>{static_cast<int>(graph.edges.size()) - 1});
}

/// Poses 1 m apart along x.
template <class G>
PoseGraph<G> straight_chain(int poses) {
  PoseGraph<G> graph;
  for (int i = 0; i < poses; ++i) graph.add_pose(G(G::Vector::Unit(0) * i, G().rotation()));
  return graph;
}
/// Steps are measured with variances of 0.01 m² and 1e-4 rad², loops with 4e-4 m² and 1e-4 rad².
template <class G>
void join_ahead(PoseGraph<G>& graph, int from, int to, double measured_m, bool loop) {
  constexpr int kAxes = static_cast<int>(G::Vector::RowsAtCompileTime);
  // A quaternion's vector part is half the angle.
  TangentOf<G> information = TangentOf<G>::Constant(G::kDof == 6 ? 4e4 : 1e4);
  information.template head<kAxes>().setConstant(loop ? 2500.0 : 100.0);
  graph.edges.push_back({from, to, G(G::Vector::Unit(0) * measured_m, G().rotation()),
                         information.asDiagonal(), loop});
}

// A chain of 41 poses and a loop from its first to its last, 0.9 m longer. With Σ j = 780 and
// Σ j² = 20540 over the remaining distances j, its cycle has the variances 0.4 + 4e-4 m² along the
// chain, 0.4004 m² + 1e-4 Σ j² across and 41e-4 rad², and the covariance 1e-4 Σ j of a rotation and
// the displacement that it causes. The positions have the variance (41² − 1)/12 = 140 m², the
// distance of two of them 2 · 140/n by axis; a heading has π²/3. A false loop agrees as well with
// p = V dⁿ √(det S/((2π)ⁿ det(S + D))), V = 4π/3 or π³/6.
TYPED_TEST(LoopConsistency, ALoopIsAcceptedByItsSignificance) {
  using G = TypeParam;
  constexpr int kDof = G::kDof, kAxes = static_cast<int>(G::Vector::RowsAtCompileTime);
  constexpr double kPi = std::numbers::pi, kError_m = 0.9;
  SquareOf<G> s = 41e-4 * SquareOf<G>::Identity(), unrelated = kPi * kPi / 3.0 * s.Identity();
  for (int k = 0; k < kAxes; ++k) {
    s(k, k) = k == 0 ? 0.4004 : 0.4004 + 2.054;
    unrelated(k, k) = 2.0 * 140.0 / kAxes;
  }
  s(1, kDof - 1) = s(kDof - 1, 1) = 0.078;
  if (kDof == 6) s(2, kDof - 2) = s(kDof - 2, 2) = -0.078;
  const double ball = kDof == 3 ? 4.0 / 3.0 * kPi : kPi * kPi * kPi / 6.0;
  const double p = ball * std::pow(kError_m * kError_m / 0.4004, 0.5 * kDof) *
                   std::sqrt(s.determinant() / (s + unrelated).eval().determinant()) *
                   std::pow(2.0 * kPi, -0.5 * kDof);
  for (const double part : {0.98, 1.02}) {
    PoseGraph<G> graph = straight_chain<G>(41);
    for (int i = 0; i < 40; ++i) join_ahead(graph, i, i + 1, 1.0, false);
    join_ahead(graph, 0, 40, 40.0 + kError_m, true);
    const auto report =
        optimise_consistent_loops(graph, {.max_false = part * p, .noise_scale = 1.0});
    ASSERT_TRUE(report) << report.error().to_string();
    EXPECT_EQ(report->rejected, part > 1.0 ? std::vector<int>{} : std::vector<int>{40}) << p;
    EXPECT_EQ(report->undecided, report->rejected);
    EXPECT_EQ(report->noise_scale, 1.0);
    EXPECT_GT(report->rounds, 0);
    EXPECT_GT(report->iterations, 0);
  }
}

// Loops over ten steps of an exact chain whose errors along it have given d², in quantiles of χ² at
// 1/4; S is there 10 · 0.01 + 4e-4. Of 25 loops the seventh least, at the quarter, gives the scale,
// (1 + 5/√25) · 0.2; of one, 1 + 5 times its own, from 1/32 to 1.
TYPED_TEST(LoopConsistency, TheScaleOfTheNoiseIsThatOfTheBestQuarter) {
  using G = TypeParam;
  std::vector<double> quarter(25, 0.8);
  std::fill_n(quarter.begin(), 6, 0.0);
  quarter[11] = 0.2;
  for (const auto& [quantiles, scale] : {std::pair{quarter, 0.4},
                                         {std::vector{0.1}, 0.6},
                                         {std::vector{0.0}, 1.0 / 32.0},
                                         {std::vector{0.2}, 1.0}}) {
    PoseGraph<G> graph = straight_chain<G>(35);
    for (int i = 0; i < 34; ++i) join_ahead(graph, i, i + 1, 1.0, false);
    for (std::size_t k = 0; k < quantiles.size(); ++k) {
      const double square = quantiles[k] * chi_square_quantile(0.25, G::kDof);
      const int from = static_cast<int>(k);
      join_ahead(graph, from, from + 10, 10.0 + std::sqrt(square * 0.1004), true);
    }
    const auto report = optimise_consistent_loops(graph);
    ASSERT_TRUE(report) << report.error().to_string();
    EXPECT_NEAR(report->noise_scale, scale, 1e-6);
  }
}

TYPED_TEST(LoopConsistency, DoesNotDependOnThreadsNorOnInitialPoses) {
  Laps<TypeParam> laps(160, 5);
  laps.add_group(10, 65, 15);
  auto one = laps.graph(), two = laps.graph();
  ASSERT_TRUE(start_from_odometry(two));
  LoopConsistencyOptions options;
  const auto first = optimise_consistent_loops(one, options);
  options.optimise.threads = 3;
  const auto second = optimise_consistent_loops(two, options);
  ASSERT_TRUE(first);
  ASSERT_TRUE(second);
  EXPECT_EQ(first->rejected, second->rejected);
  for (std::size_t k = 0; k < one.poses.size(); ++k) expect_same(one.poses[k], two.poses[k]);
}

TYPED_TEST(LoopConsistency, RefusesWhatItCannotUse) {
  PoseGraph<TypeParam> empty;
  EXPECT_THAT(optimise_consistent_loops(empty).error().message, HasSubstr("no poses"));

  const auto whole = Laps<TypeParam>(100, 1).graph();
  auto broken = whole;
  broken.edges.erase(broken.edges.begin() + 7);  // 7 -> 8
  const auto message = optimise_consistent_loops(broken).error().message;
  EXPECT_THAT(message, HasSubstr("no trusted edge joins poses 7 and 8"));

  auto infinite = whole;
  infinite.edges.back().measurement =
      TypeParam(TypeParam::Vector::Constant(std::nan("")), infinite.poses.front().rotation());
  EXPECT_THAT(optimise_consistent_loops(infinite).error().message,
              HasSubstr("measurement that is not finite"));
  for (std::size_t k = 0; k < whole.poses.size(); ++k) expect_same(broken.poses[k], whole.poses[k]);
}

TYPED_TEST(LoopConsistency, OptionsWithoutSenseAreErrors) {
  const double nan = std::nan("");
  std::vector<LoopConsistencyOptions> all;
  for (const double bad : {nan, -1.0, 0.0, 1.0, 2.0}) all.push_back({.inlier_probability = bad});
  for (const double bad : {nan, -1.0}) all.push_back({.max_false = bad});
  for (const double bad : {nan, -1.0, std::numeric_limits<double>::infinity()})
    all.push_back({.noise_scale = bad});
  for (const auto& options : all) {
    auto graph = Laps<TypeParam>(60, 1).graph();
    const auto report = optimise_consistent_loops(graph, options);
    ASSERT_FALSE(report);
    EXPECT_EQ(report.error().code, ErrorCode::invalid);
  }
}

}  // namespace
}  // namespace wayfare
