// IncrementalOptimiser at its borders; random calls are in sequences/.

#include <cmath>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "abuse/graph_cases.hpp"

namespace wayfare::tests {
namespace {

using ::testing::HasSubstr;

template <class G>
class IncrementalAbuse : public ::testing::Test {};
using GrowingGroups = ::testing::Types<SE2d, SE3d>;
TYPED_TEST_SUITE(IncrementalAbuse, GrowingGroups);

template <class G>
IncrementalOptimiser<G> grown() {
  IncrementalOptimiser<G> growing;
  EXPECT_TRUE(growing.append(twelve<G>()));
  EXPECT_TRUE(growing.update());
  return growing;
}

TYPED_TEST(IncrementalAbuse, MayBeGivenItsOwnPosesEdgesAndGraph) {
  auto growing = grown<TypeParam>();
  for (int again = 0; again < 100; ++again) {
    const std::size_t edges = growing.graph().edges.size();
    ASSERT_TRUE(growing.add_edge(growing.graph().edges[static_cast<std::size_t>(again)]));
    ASSERT_EQ(growing.graph().edges.size(), edges + 1);
    ASSERT_TRUE(growing.add_pose(growing.poses().back(), true));
  }
  const Bits before = bits_of(growing.graph());
  ASSERT_TRUE(growing.append(growing.graph()));
  EXPECT_TRUE(bits_of(growing.graph()) == before);
  EXPECT_TRUE(growing.update());
}

// A pose that was discarded takes its name along.
TYPED_TEST(IncrementalAbuse, LabelsOfDiscardedPosesAreForgotten) {
  using G = TypeParam;
  auto growing = grown<G>();
  auto more = growing.graph();
  more.add_pose(G());
  for (int i = 0; i < more.size(); ++i) more.labels.push_back("p" + std::to_string(i));
  more.labels.back() = "never connected";
  ASSERT_TRUE(growing.append(more));
  const auto refused = growing.update();
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("pose never connected"));
  growing.discard_pending();
  ASSERT_TRUE(growing.add_pose(G()));
  const auto next = growing.update();
  ASSERT_FALSE(next);
  EXPECT_THAT(next.error().message, HasSubstr("pose 12 is not connected to pose p0"));
}

// Fixed poses among those that are pending are fixed, whichever call says so.
TYPED_TEST(IncrementalAbuse, APendingPoseCanBeFixedByTheNextGraph) {
  using G = TypeParam;
  auto graph = twelve<G>();
  graph.fixed = {0, 3, 11};
  auto expected = graph;
  ASSERT_TRUE(optimise(expected));
  for (const int first : {1, 6, 12}) {
    IncrementalOptimiser<G> growing;
    for (int i = 0; i < first; ++i)
      ASSERT_TRUE(growing.add_pose(graph.poses[static_cast<std::size_t>(i)]));
    ASSERT_TRUE(growing.append(graph));
    ASSERT_TRUE(growing.optimise_fully());
    EXPECT_LT(apart(growing.poses(), expected.poses), 1e-9) << first;
    for (const std::size_t held : {0U, 3U, 11U})
      EXPECT_EQ(growing.poses()[held].minus(graph.poses[held]).norm(), 0.0);
  }
}

// Options are those of one update; the next one is not spoiled by them.
TYPED_TEST(IncrementalAbuse, OptionsWithoutSenseDoNotLast) {
  using G = TypeParam;
  std::vector<IncrementalOptions> all;
  for (const double odd : {kNan, kInf, -kInf, -1.0, kHuge, kTiny}) {
    all.push_back({.relinearise_step = odd});
    all.push_back({.solve_change = odd});
    all.push_back({.reorder_work = odd});
    all.push_back({.relinearise_step = odd, .solve_change = odd, .reorder_work = odd});
  }
  for (const int rounds : {-1, 0, 50}) all.push_back({.max_rounds = rounds});
  Rng rng(3);
  const auto whole = random_walk<G>(rng, 30);
  auto batch = whole;
  ASSERT_TRUE(optimise(batch, {.min_relative_gain = 1e-14, .min_absolute_gain = 1e-14}));
  for (const auto& options : all) {
    IncrementalOptimiser<G> growing;
    ASSERT_TRUE(growing.add_pose(whole.poses[0]));
    for (const auto& step : replay_steps(whole)) {
      if (step.new_pose >= 0) {
        ASSERT_TRUE(growing.add_pose(step.placed(growing.poses())));
      }
      ASSERT_TRUE(growing.add_edge(step.edge));
      ASSERT_TRUE(growing.update(options));
      ASSERT_TRUE(all_finite(growing.poses()));
    }
    IncrementalOptions exact = kExact;
    exact.max_rounds = 12;
    ASSERT_TRUE(growing.update(exact));
    EXPECT_LT(apart(growing.poses(), batch.poses), 1e-6)
        << options.relinearise_step << ' ' << options.solve_change << ' ' << options.reorder_work;
  }
}

TYPED_TEST(IncrementalAbuse, CopiesAndMovesGoOnByThemselves) {
  using G = TypeParam;
  auto source = grown<G>();
  const auto pending = source.add_pose(source.poses().back());
  ASSERT_TRUE(pending);
  expect_value_semantics(source, [](IncrementalOptimiser<G>& growing) {
    EXPECT_TRUE(growing.add_edge({4, 12, G::exp(TangentOf<G>::Constant(0.2))}));
    EXPECT_TRUE(growing.update());
    EXPECT_TRUE(growing.add_edge({12, 0, G::exp(TangentOf<G>::Constant(0.3))}));
    EXPECT_TRUE(growing.update());
    return bits_of(growing.graph());
  });
}

TYPED_TEST(IncrementalAbuse, TwoThreadsDoNotDisturbEachOther) {
  const auto shared = grown<TypeParam>();
  const auto both = in_two_threads([&](int) {
    auto growing = shared;
    Rng rng(6);
    const auto whole = random_walk<TypeParam>(rng, 60);
    auto more = growing.graph();
    for (int i = 12; i < 60; ++i) more.add_pose(whole.poses[static_cast<std::size_t>(i)]);
    for (const auto& edge : whole.edges)
      if (std::max(edge.from, edge.to) >= 12) more.edges.push_back(edge);
    EXPECT_TRUE(growing.append(more));
    EXPECT_TRUE(growing.update());
    EXPECT_TRUE(growing.optimise_fully({.threads = 2}));
    return bits_of(growing.graph());
  });
  EXPECT_TRUE(both[0] == both[1]);
}

// Numbers whose squares or products overflow: each call ends in finite poses, or in an Error that
// leaves them as they were.
TYPED_TEST(IncrementalAbuse, NumbersOfAnySizeLeaveFinitePosesOrNoChange) {
  using G = TypeParam;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Rng rng(seed);
    const double most = std::pow(10.0, rng.uniform(0.0, 308.0));
    const auto size = [&] { return rng.below(3) == 0 ? most * rng.uniform(-1.0, 1.0) : 1.0; };
    IncrementalOptimiser<G> growing;
    ASSERT_TRUE(growing.add_pose(G()));
    for (int k = 1; k < 12; ++k) {
      const G step = moved_to<G>(size()) * G::exp(random_tangent<G>(rng, 1.0));
      (void)growing.add_pose(rng.below(4) == 0 ? moved_to<G>(size())
                                               : growing.poses().back() * step);
      const int last = growing.graph().size() - 1;
      for (int edges = 0; edges < 2; ++edges) {
        const int from = edges == 0 ? last - 1 : static_cast<int>(rng.below(12)) % (last + 1);
        (void)growing.add_edge({from, last, edges == 0 ? step : moved_to<G>(size()),
                                std::abs(size()) * SquareOf<G>::Identity(), edges == 1});
      }
      const Bits before = bits_of(growing.graph());
      const auto done = growing.update();
      ASSERT_TRUE(all_finite(growing.poses()));
      if (done) {
        ASSERT_FALSE(std::isnan(done->cost));
        continue;
      }
      ASSERT_TRUE(bits_of(growing.graph()) == before) << done.error().message;
      growing.discard_pending();
      if (growing.graph().poses.empty()) {
        ASSERT_TRUE(growing.add_pose(G()));
      }
    }
  }
}

}  // namespace
}  // namespace wayfare::tests
