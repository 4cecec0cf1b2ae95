// Iterations must not allocate, so that an optimisation beside a robot's driver does not block.

#include <gtest/gtest.h>

#include <wayfare/graph/detail/damped_step.hpp>
#include <wayfare/graph/optimise.hpp>

#include "core/counted_heap.hpp"
#include "tangle.hpp"

namespace wayfare {
namespace {

template <class G>
class IterationHeap : public ::testing::Test {};
using Groups = ::testing::Types<SE2d, SE3d>;
TYPED_TEST_SUITE(IterationHeap, Groups);

TYPED_TEST(IterationHeap, NothingIsAllocatedAfterTheFirstIteration) {
  WAYFARE_NEEDS_COUNTED_HEAP();
  using G = TypeParam;
  Rng rng(5);
  auto graph = tests::tangle<G>(rng);
  DampedStep<PoseGraph<G>, DefaultSolver<G::kDof>> step;
  const RobustKernel kernel{RobustKernelKind::cauchy, 1.0};
  std::size_t taken[3] = {};
  for (std::size_t& count : taken) {
    const std::size_t before = tests::allocations;
    step.prepare(graph);
    step.linearise(graph, kernel);
    step.compute(1e-4);
    step.apply(graph);
    step.cost(graph, kernel);
    count = tests::allocations - before;
  }
  EXPECT_GT(taken[0], 0U);
  EXPECT_EQ(taken[1], 0U);
  EXPECT_EQ(taken[2], 0U);
}

}  // namespace
}  // namespace wayfare
