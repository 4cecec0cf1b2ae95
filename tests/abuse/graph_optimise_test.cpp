// Batch computations on pose graphs that are invalid, extreme or merely strange.

#include <cmath>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "abuse/graph_cases.hpp"

namespace wayfare::tests {
namespace {

using ::testing::HasSubstr;

template <class G>
class GraphAbuse : public ::testing::Test {};
using Groups = ::testing::Types<SE2d, SE3d>;
TYPED_TEST_SUITE(GraphAbuse, Groups);

TYPED_TEST(GraphAbuse, EveryFaultIsRefusedByAllAndNothingChanges) {
  for (const auto& fault : faults<TypeParam>()) {
    auto graph = twelve<TypeParam>();
    fault.change(graph);
    const Bits before = bits_of(graph);
    for (const auto& computation : computations<TypeParam>()) {
      const auto done = computation.run(graph);
      EXPECT_FALSE(done) << computation.name << " took " << fault.name;
      EXPECT_TRUE(bits_of(graph) == before) << computation.name << " changed " << fault.name;
    }
  }
}

TYPED_TEST(GraphAbuse, AnOddGraphGivesNumbersOrAnErrorAndNoChange) {
  for (const auto& oddity : oddities<TypeParam>()) {
    auto odd = twelve<TypeParam>();
    oddity.change(odd);
    const Bits before = bits_of(odd);
    const bool valid = static_cast<bool>(validate(odd));
    for (const auto& computation : computations<TypeParam>()) {
      SCOPED_TRACE(computation.name + " of " + oddity.name);
      auto graph = odd;
      const auto done = computation.run(graph);
      if (!done) {
        EXPECT_NE(done.error().message, "");
        EXPECT_TRUE(bits_of(graph) == before) << done.error().message;
        continue;
      }
      EXPECT_TRUE(valid);
      EXPECT_TRUE(all_finite(graph.poses));
      for (const int pose : odd.fixed)
        EXPECT_EQ(bits_of<TypeParam>({graph.poses.at(static_cast<std::size_t>(pose))}),
                  bits_of<TypeParam>({odd.poses.at(static_cast<std::size_t>(pose))}));
    }
  }
}

// What is odd, but well conditioned, has no excuse.
TYPED_TEST(GraphAbuse, StrangeGraphsThatDetermineTheirPosesAreSolved) {
  for (const auto& oddity : oddities<TypeParam>()) {
    const bool fine = oddity.name.find("1e") == std::string::npos ||
                      oddity.name == "poses at 1e9" || oddity.name == "information of 1 1e30" ||
                      oddity.name == "information of 0 1e30";
    auto graph = twelve<TypeParam>();
    oddity.change(graph);
    if (!fine || !validate(graph)) continue;
    for (const auto& computation : computations<TypeParam>()) {
      const auto done = computation.run(graph);
      EXPECT_TRUE(done) << computation.name << " of " << oddity.name << ": "
                        << done.error().message;
    }
  }
}

// The result of optimisation does not depend on where the map is, to rounding of its coordinates.
TYPED_TEST(GraphAbuse, AMapAtOneBillionMetresIsTheSameMap) {
  using G = TypeParam;
  auto near = twelve<G>();
  auto far = near;
  const G there = moved_to<G>(1e9);
  for (auto& x : far.poses) x = there * x;
  PoseGraphOptimiser<G> optimiser;
  ASSERT_TRUE(optimiser.optimise(near));
  const auto covariances = optimiser.covariances(near);
  ASSERT_TRUE(optimiser.optimise(far));
  const auto far_covariances = optimiser.covariances(far);
  ASSERT_TRUE(covariances && far_covariances);
  for (std::size_t i = 0; i < near.poses.size(); ++i) {
    EXPECT_LT((there * near.poses[i]).minus(far.poses[i]).norm(), 1e-5);
    EXPECT_LE(((*covariances)[i] - (*far_covariances)[i]).norm(), 1e-5 * (*covariances)[i].norm());
  }
}

TYPED_TEST(GraphAbuse, AnEdgeGivenTwiceCountsTwice) {
  using G = TypeParam;
  auto twice = twelve<G>();
  auto doubled = twice;
  for (auto& edge : doubled.edges) edge.information *= 2.0;
  for (const auto edges = twice.edges; const auto& edge : edges) twice.edges.push_back(edge);
  PoseGraphOptimiser<G> optimiser;
  const OptimiseOptions options{.min_relative_gain = 1e-14, .min_absolute_gain = 1e-14};
  ASSERT_TRUE(optimiser.optimise(twice, options));
  const auto covariances = optimiser.covariances(twice);
  ASSERT_TRUE(optimiser.optimise(doubled, options));
  const auto expected = optimiser.covariances(doubled);
  ASSERT_TRUE(covariances && expected);
  EXPECT_LT(apart(twice.poses, doubled.poses), 1e-7);
  for (std::size_t i = 0; i < expected->size(); ++i)
    EXPECT_LE(((*covariances)[i] - (*expected)[i]).norm(), 1e-6 * (*expected)[i].norm());
}

// Options without sense end in an Error or in a cost that is not higher, and soon.
TYPED_TEST(GraphAbuse, OptionsWithoutSenseDoNoHarm) {
  std::vector<OptimiseOptions> all;
  for (const int iterations : {-1, 0, 1}) all.push_back({.max_iterations = iterations});
  all.push_back({.threads = 1'000'000'000});
  for (const double odd : {kNan, kInf, -kInf, -1.0, 0.0, kHuge, kTiny}) {
    all.push_back({.min_relative_gain = odd});
    all.push_back({.min_absolute_gain = odd});
    all.push_back({.initial_damping = odd});
    all.push_back({.initial_damping = odd, .max_damping = odd});
    for (const auto kind :
         {RobustKernelKind::huber, RobustKernelKind::cauchy, RobustKernelKind::geman_mcclure,
          RobustKernelKind::dynamic_covariance_scaling})
      all.push_back({.kernel = {kind, odd}});
  }
  auto start = twelve<TypeParam>();
  for (auto& edge : start.edges) edge.robust = edge.to % 2 == 0;
  for (auto options : all) {
    for (const auto method : {OptimiseMethod::gauss_newton, OptimiseMethod::levenberg_marquardt}) {
      options.method = method;
      auto graph = start;
      const auto report = optimise(graph, options);
      EXPECT_TRUE(all_finite(graph.poses));
      if (report) {
        EXPECT_LE(report->final_cost, report->initial_cost);
      } else {
        EXPECT_TRUE(bits_of(graph) == bits_of(start));
      }
    }
  }
}

TYPED_TEST(GraphAbuse, GncOptionsWithoutSenseDoNoHarm) {
  std::vector<GncOptions> all;
  for (const double p : {0.0, 1e-300, 0.5, 1.0 - 1e-16}) all.push_back({.inlier_probability = p});
  for (const double growth : {kNan, kInf, -1.0, 0.0, 1.0, 1e300})
    all.push_back({.growth = growth, .max_rounds = 30});
  for (const int rounds : {-1, 0, 1}) all.push_back({.max_rounds = rounds});
  Rng rng(4);
  const auto start = random_walk<TypeParam>(rng, 30, true);
  for (auto options : all) {
    for (const auto loss : {GncLoss::truncated_least_squares, GncLoss::geman_mcclure}) {
      options.loss = loss;
      auto graph = start;
      const auto report = optimise_gnc(graph, options);
      EXPECT_TRUE(all_finite(graph.poses));
      if (!report) {
        EXPECT_TRUE(bits_of(graph) == bits_of(start));
        continue;
      }
      EXPECT_TRUE(std::is_sorted(report->rejected.begin(), report->rejected.end()));
      for (const int edge : report->rejected)
        EXPECT_TRUE(graph.edges.at(static_cast<std::size_t>(edge)).robust);
    }
  }
}

// The pose that an earlier graph left undetermined is not one of the next graph.
TYPED_TEST(GraphAbuse, AnUndeterminedPoseIsThatOfTheLastCall) {
  using G = TypeParam;
  auto open = twelve<G>();
  SquareOf<G> some = SquareOf<G>::Identity();
  some(0, 0) = 0.0;
  open.edges.push_back({11, open.add_pose(open.poses.back()), G(), some});
  PoseGraph<G> apart;
  apart.add_pose(G());
  apart.add_pose(G());
  for (const bool covariances : {false, true}) {
    PoseGraphOptimiser<G> optimiser;
    ASSERT_FALSE(optimiser.optimise(open));
    EXPECT_EQ(optimiser.undetermined().variable, 12);
    ASSERT_FALSE(covariances ? optimiser.prepare_covariances(apart)
                             : outcome(optimiser.optimise(apart)));
    EXPECT_EQ(optimiser.undetermined().variable, -1);
  }
}

// Lengths that are numbers, but whose sum is none.
TYPED_TEST(GraphAbuse, AStartThatOverflowsIsNamed) {
  using G = TypeParam;
  PoseGraph<G> graph;
  for (int i = 0; i < 4; ++i) graph.add_pose(moved_to<G>(i));
  for (int i = 1; i < 4; ++i) graph.edges.push_back({i - 1, i, moved_to<G>(1e308)});
  const Bits before = bits_of(graph);
  for (const auto method : {StartMethod::odometry, StartMethod::tree}) {
    const auto done = start_from(graph, method);
    ASSERT_FALSE(done);
    EXPECT_THAT(done.error().message, HasSubstr("pose 2 is too far away"));
    EXPECT_TRUE(bits_of(graph) == before);
  }
}

TYPED_TEST(GraphAbuse, AnOptimiserMayBeMovedAtAnyTime) {
  const auto make = [] {
    PoseGraphOptimiser<TypeParam> optimiser;
    auto first = twelve<TypeParam>(2);
    EXPECT_TRUE(optimiser.optimise(first));
    return optimiser;
  };
  expect_move_semantics(make, [](PoseGraphOptimiser<TypeParam>& optimiser) {
    Bits all;
    for (const std::uint64_t seed : {2U, 3U}) {
      auto graph = twelve<TypeParam>(seed);
      EXPECT_TRUE(optimiser.optimise(graph, {.threads = 2}));
      const auto covariances = optimiser.covariances(graph);
      EXPECT_TRUE(covariances);
      all = bits_of(graph);
      for (const auto& c : *covariances) add_bits(all, c);
      add_bits(all, optimiser.relative_covariance(graph, 3, 9));
    }
    return all;
  });
  PoseGraphOptimiser<TypeParam> used = make();
  const PoseGraphOptimiser<TypeParam> taken = std::move(used);
  auto graph = twelve<TypeParam>(2);
  // NOLINTNEXTLINE(bugprone-use-after-move): what the test is about
  EXPECT_TRUE(used.optimise(graph)) << "a moved-from optimiser is like a new one";
}

TYPED_TEST(GraphAbuse, TwoThreadsDoNotDisturbEachOther) {
  const auto all = in_two_threads([](int) {
    Bits bits;
    for (const auto& computation : computations<TypeParam>()) {
      auto graph = twelve<TypeParam>();
      EXPECT_TRUE(computation.run(graph)) << computation.name;
      const Bits more = bits_of(graph);
      bits.insert(bits.end(), more.begin(), more.end());
    }
    return bits;
  });
  EXPECT_TRUE(all[0] == all[1]);
}

}  // namespace
}  // namespace wayfare::tests
